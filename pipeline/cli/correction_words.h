#pragma once
/// What a technician marked or segmented elsewhere: --seeds, --labels, --coverage and what explains
/// them.

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
  std::string coverage;  ///< a folder, or "none"; empty: not given
  std::string label_map;
};

/// Adds --seeds, --seeds-phase, --seeds-radius, --labels, --labels-phases, --coverage, --label-map.
void add_correction_words(CLI::App& command, CorrectionWords& words);

/// Reads what the words name into `orders`; what they do not name stays as it is.
/// @throws Error{Usage} for words that cannot be meant; Error{InvalidInput} for their files
void take_corrections(const CorrectionWords& words, build::Orders& orders);

/// Beside labels of some phases those of the others that a study was given before stay.
/// @return whether any did  @throws Error{InvalidInput} naming the file, see with_other_phases
bool keep_other_phases(const std::optional<study::GivenLabels>& before, build::Orders& orders);

}  // namespace beatlas::cli
