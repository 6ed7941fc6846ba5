#pragma once
/// How a stage's result stands to what it would be made from now.

#include <optional>
#include <string>
#include <vector>

#include "pipeline/study/study.h"

namespace beatlas::study {

/// What a stage would be run with.
struct Wanted {
  std::string version;         ///< of the program
  std::string sources_sha256;  ///< of the program
  nlohmann::json options = nlohmann::json::object();
  std::optional<std::string> source_files = {};  ///< of Import: hash of the files named now, if any
};

struct StageState {
  bool ran = false;                  ///< to its end
  std::vector<std::string> edited;   ///< outputs whose bytes are no longer those it wrote
  std::vector<std::string> missing;  ///< outputs that are gone
  std::vector<std::string> changed;  ///< what differs from when it ran; files, or words

  [[nodiscard]] bool up_to_date() const { return ran && missing.empty() && changed.empty(); }
};

/// Files for the eye do not count as edited. labels_as_made.nii.gz, if it is not what was written,
/// counts as missing: without it no edit can be told. An import by another build of the program
/// stands as long as no images are named that could be read anew.
[[nodiscard]] StageState state_of(const Study& study, Stage stage, const Wanted& wanted);

/// Outputs that later stages read and whose bytes are no longer those that `stage` wrote.
[[nodiscard]] std::vector<std::string> edited_outputs(const Study& study, Stage stage);

/// Outputs for the eye that were changed by hand: nothing follows from them.
[[nodiscard]] std::vector<std::string> edited_for_the_eye(const Study& study, Stage stage);

}  // namespace beatlas::study
