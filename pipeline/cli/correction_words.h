#pragma once
/// What a technician marked or segmented elsewhere: --seeds, --labels, --coverage and what explains
/// them.

#include <optional>
#include <string>
#include <vector>

#include "pipeline/cli/orders.h"
#include "pipeline/core/exam.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/segment/given_coverage.h"

namespace CLI {
class App;
}

namespace beatlas::cli {

struct CorrectionWords {
  std::string seeds;  ///< a file, or "none"; empty: not given
  std::optional<int> seeds_phase;
  std::optional<double> seeds_radius_mm;
  std::string labels;  ///< the same
  std::string labels_phases;
  std::string coverage;  ///< a folder, or "none"; empty: not given
  std::string label_map;
};

/// Adds --seeds, --seeds-phase, --seeds-radius, --labels, --labels-phases, --coverage, --label-map.
void add_correction_words(CLI::App& command, CorrectionWords& words);

/// Reads what the words name into `orders`; what they do not name stays as it is.
/// @throws Error{Usage} for words that cannot be meant; Error{InvalidInput} for their files
void take_corrections(const CorrectionWords& words, Orders& orders);

/// The same on the grid and in the phases of an exam.
struct Corrections {
  std::vector<segment::Seed> seeds;  ///< drawn and painted
  segment::KnownLabels known;
  segment::GivenCoverage coverage;
};
/// Labels are moved with the exam's slices unless the recipe says otherwise; seeds lie where the
/// study's images show them.
/// @throws Error{InvalidInput} naming the user's file that does not fit
[[nodiscard]] Corrections corrections_for(const Exam& exam, const Orders& orders,
                                          StageContext& context);

/// Segments an exam with what was made by hand, if anything was.
/// @param prior see segment_exam
[[nodiscard]] Segmentation segment_with(const Exam& exam, const Corrections& corrections,
                                        const segment::SegmentOptions& options,
                                        StageContext& context, const prior::PriorCycle* prior);

}  // namespace beatlas::cli
