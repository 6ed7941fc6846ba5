#pragma once
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/long_axis.h"
#include "pipeline/study/study.h"

namespace beatlas::build {

struct StageStatus {
  study::Stage stage{};
  std::string state;                      ///< see cmd_status
  std::vector<std::string> edited;        ///< files changed by hand
  std::vector<std::string> unused_edits;  ///< files changed by hand that no stage reads
  std::vector<std::string> missing;       ///< files that are gone
  std::vector<std::string> changed;       ///< why it is stale
  std::string refused;                    ///< why the last build ended here without a package
};

struct StudyStatus {
  std::vector<StageStatus> stages;  ///< in order
  std::optional<LongAxis> axis;     ///< as it is now, if segment will not run again
  bool in_use = false;              ///< another program writes in the study now
};

[[nodiscard]] StudyStatus status_of(const study::Study& study);

/// A line a stage, and what else there is to tell. Of more than three files of a folder the number.
[[nodiscard]] std::string to_text(const StudyStatus& status);
/// See schemas/status.schema.json.
[[nodiscard]] nlohmann::json to_json(const StudyStatus& status);

}  // namespace beatlas::build
