#pragma once
/// What a technician marked or segmented elsewhere: --seeds, --labels, --coverage and what explains
/// them.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/build/orders.h"

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
  bool labels_aligned = false;  ///< drawn on the study's own images
  std::string coverage;         ///< a folder, or "none"; empty: not given
  std::string label_map;
};

/// Adds --seeds, --seeds-phase, --seeds-radius, --labels, --labels-phases, --labels-aligned,
/// --coverage,
/// --label-map.
void add_correction_words(CLI::App& command, CorrectionWords& words);

/// Reads what the words name into `orders`; what they do not name stays as it is.
/// @throws Error{Usage} for words that cannot be meant; Error{InvalidInput} for their files
void take_corrections(const CorrectionWords& words, build::Orders& orders);

/// Labels that were drawn on a study's own images, in which import has moved slices, become such as
/// are drawn on the images as they came: all labels of a study are, unless its recipe says
/// otherwise.
/// @param study its folder, with an import that stays
void take_back_alignment(const std::filesystem::path& study, const CorrectionWords& words,
                         const build::Orders& before, build::Orders& orders);

/// Beside labels of some phases that were named, those of the others stay that a study was given
/// before.
/// @param study its folder, with an import that stays
/// @throws Error{InvalidInput} naming the file, for a phase that the study lacks, for coverage of
/// the labels before, and see with_other_phases
void keep_other_phases(const std::filesystem::path& study, const build::Orders& before,
                       build::Orders& orders);

}  // namespace beatlas::cli
