#pragma once
/// What the stages are run with: from the command's words, else from the study.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/build/recipe.h"
#include "pipeline/segment/segment.h"
#include "pipeline/study/given_files.h"
#include "pipeline/study/state.h"
#include "pipeline/study/study.h"

namespace beatlas::build {

struct Orders {
  Recipe recipe;
  std::vector<segment::Seed> seeds;
  std::optional<study::GivenLabels> painted;  ///< seeds too; segment::kNotPainted where none are
  std::string seeds_from;                     ///< where they are written, for messages
  std::optional<study::GivenLabels> labels;   ///< a segmentation from elsewhere
  std::string labels_from;
  std::map<Structure, study::GivenImages> coverage;  ///< of those labels
  std::string coverage_from;
  /// Seeds, or labels, were kept by the study: they are of the images it was made from.
  bool keeps_seeds = false;
  bool keeps_labels = false;
  /// Of the model that recipe.segment.prior names, see learned_prior.h; in place of its name it
  /// tells what segmentation was run with.
  std::string prior_sha256;
  bool discard_edits = false;  ///< make anew what was edited by hand
};

/// Those the study was last built with. @throws Error{InvalidInput} naming study.json.
[[nodiscard]] Orders orders_of(const study::Study& study);
/// Has the study hold recipe, seeds and labels for later commands; they are saved with the next
/// stage that is left, or at the command's end: one whose input is refused leaves no trace.
void keep_orders(const Orders& orders, study::Study& study);

/// What a stage would be run with; of Pack without scene and quality, see pack_options.
[[nodiscard]] study::Wanted wanted_of(study::Stage stage, const Orders& orders);

}  // namespace beatlas::build
