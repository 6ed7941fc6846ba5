#include "pipeline/study/stage.h"

namespace beatlas::study {

std::string_view stage_name(Stage stage) noexcept {
  constexpr std::array<std::string_view, kAllStages.size()> kNames{
      "import", "segment", "pictures", "register", "field", "mesh", "pack"};
  return kNames[static_cast<std::size_t>(stage)];
}

std::string_view stage_command(Stage stage) noexcept {
  return stage_name(stage == Stage::Pictures ? Stage::Segment : stage);
}

std::vector<Stage> sources_of(Stage stage) {
  switch (stage) {
    case Stage::Import:
      return {};
    case Stage::Segment:
      return {Stage::Import};
    case Stage::Pictures:
    case Stage::Register:
      return {Stage::Import, Stage::Segment};
    case Stage::Field:
      return {Stage::Register};
    case Stage::Mesh:  // the long axis and where the heart lies, for the LV's map
      return {Stage::Segment, Stage::Register, Stage::Field};
    case Stage::Pack:
      break;
  }
  return {Stage::Import, Stage::Segment, Stage::Register, Stage::Field, Stage::Mesh};
}

bool reads(Stage stage, Stage source, std::string_view file) noexcept {
  if (for_the_eye(file)) return false;
  if (stage != Stage::Mesh || source == Stage::Field) return true;
  return file == "segment/long_axis.json" || file == "register/register.json";
}

bool for_the_eye(std::string_view file) noexcept {
  return file.starts_with("pictures/") || file.starts_with("pack/") ||
         file.starts_with("segment/uncertainty_") || file == kLabelsAsAcquired ||
         file == "register/cine.nii.gz" || file == "register/labels.nii.gz";
}

}  // namespace beatlas::study
