#include "pipeline/build/study_status.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/build/orders.h"
#include "pipeline/study/lock.h"
#include "pipeline/study/long_axis_json.h"
#include "pipeline/study/stage_files.h"
#include "pipeline/study/state.h"
#include "runtime/base/error.h"

namespace beatlas::build {
using study::Stage;
namespace {

StageStatus status_of(const study::Study& study, Stage stage, const Orders& orders) {
  StageStatus out;
  out.stage = stage;
  const study::StageRecord* record = study.find(stage);
  if (!record) {
    const bool writing = study.interrupted() == stage;
    out.state = !writing ? "open" : study::Lock::held(study.folder()) ? "running" : "stopped";
    return out;
  }
  study::Wanted wanted = wanted_of(stage, orders);
  if (stage == Stage::Pack) {
    // What it was packed for is the order of the command, not of the study.
    wanted.options = record->options;
  }
  const study::StageState state = study::state_of(study, stage, wanted);
  out.edited = state.edited;
  out.unused_edits = study::edited_for_the_eye(study, stage);
  out.missing = state.missing;
  out.changed = state.changed;
  out.state = !state.edited.empty() ? "edited" : state.up_to_date() ? "done" : "stale";
  return out;
}

/// None too where the file was spoilt by hand: that is for the stage that reads it to say.
std::optional<LongAxis> axis_of(const study::Study& study) {
  try {
    return study::read_long_axis(study.folder());
  } catch (const Error&) {
    return {};
  }
}

constexpr std::size_t kMostNamed = 3;  // files of one folder; more are counted

/// "its options, 16 files of mesh/, segment/labels.nii.gz": a beat has many files, which --json
/// names one by one.
std::string joined(const std::vector<std::string>& names) {
  const auto folder_of = [](const std::string& name) {
    return name.substr(0, name.rfind('/') + 1);
  };
  std::map<std::string, std::size_t> count;
  for (const std::string& name : names) ++count[folder_of(name)];
  std::string out;
  for (const std::string& name : names) {
    const std::string folder = folder_of(name);
    std::string said = name;
    if (!folder.empty() && count[folder] > kMostNamed) {
      said = std::to_string(count[folder]) + " files of " + folder;
      count[folder] = 0;
    } else if (!folder.empty() && count[folder] == 0) {
      continue;
    }
    out += (out.empty() ? "" : ", ") + said;
  }
  return out;
}

}  // namespace

StudyStatus status_of(const study::Study& study) {
  StudyStatus out;
  out.in_use = study::Lock::held(study.folder());
  const Orders orders = orders_of(study);
  bool runs_before = false;  // a stage that others read will run again
  for (const Stage stage : study::kAllStages) {
    bool readable = true;
    for (const Stage source : study::sources_of(stage)) {
      readable = readable && study.find(source) != nullptr;
    }
    StageStatus status;
    status.stage = stage;
    if (study.find(stage) && !readable) {
      status.state = "waits";
    } else {
      status = status_of(study, stage, orders);
      if (status.state == "done" && runs_before) status.state = "waits";
    }
    if (study.refusal() && study.refusal()->stage == stage) {
      status.state = "refused";
      status.refused = study.refusal()->reason;
    }
    const bool runs = status.state != "done" && status.state != "edited";
    if (stage != Stage::Pictures) runs_before = runs_before || runs;
    if (stage == Stage::Segment && !runs) out.axis = axis_of(study);
    out.stages.push_back(std::move(status));
  }
  return out;
}

std::string to_text(const StudyStatus& status) {
  std::string out;
  for (const StageStatus& stage : status.stages) {
    std::string line(study::stage_name(stage.stage));
    line.resize(10, ' ');
    line += stage.state;
    const char* before = ": ";
    const auto add = [&](const std::string& said) {
      line += before + said;
      before = "; ";
    };
    if (!stage.edited.empty()) add(joined(stage.edited));
    if (!stage.refused.empty()) add(stage.refused);
    if (!stage.missing.empty()) add(joined(stage.missing) + " gone");
    if (!stage.changed.empty()) {
      add(joined(stage.changed) + " changed" +
          (stage.stage == Stage::Pack ? " since the last package" : ""));
    }
    if (!stage.unused_edits.empty()) {
      add(joined(stage.unused_edits) + " changed by hand, but nothing is made from it");
    }
    out += line + "\n";
  }
  if (status.axis) {
    const LongAxis& axis = *status.axis;
    double least = axis.lv_base_mm[0] - axis.apex_mm[0];
    double most = least;
    for (std::size_t p = 1; p < axis.apex_mm.size(); ++p) {
      least = std::min(least, axis.lv_base_mm[p] - axis.apex_mm[p]);
      most = std::max(most, axis.lv_base_mm[p] - axis.apex_mm[p]);
    }
    out += "LV " + std::to_string(std::lround(least)) + " to " + std::to_string(std::lround(most)) +
           " mm from apex to base, see segment/long_axis.json\n";
  }
  if (status.in_use) out += "another beatlas writes in this study now\n";
  return out;
}

nlohmann::json to_json(const StudyStatus& status) {
  nlohmann::json stages = nlohmann::json::array();
  for (const StageStatus& stage : status.stages) {
    stages.push_back({{"name", study::stage_name(stage.stage)},
                      {"state", stage.state},
                      {"edited", stage.edited},
                      {"unused_edits", stage.unused_edits},
                      {"missing", stage.missing},
                      {"changed", stage.changed}});
    if (!stage.refused.empty()) stages.back()["refused"] = stage.refused;
  }
  nlohmann::json out{{"stages", stages}, {"in_use", status.in_use}};
  if (status.axis) out["long_axis"] = study::long_axis_to_json(*status.axis);
  return out;
}

}  // namespace beatlas::build
