#include "runtime/app/press_session.h"

#include <optional>
#include <ostream>

#include <nlohmann/json.hpp>

#include "runtime/app/atlas_press.h"
#include "runtime/app/text.h"
#include "runtime/app/ventricle.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/palpation/fit.h"

namespace beatlas::app {
namespace {

// The middle of a segment's ring, for a ventricle without a map.
double long_axis_of(int segment) {
  if (segment == palpation::kSegments) return 0.04;
  return segment <= 6 ? 5.0 / 6 : segment <= 12 ? 0.5 : 1.0 / 6;
}

}  // namespace

void run_press_session(const PressArguments& arguments, std::ostream& out) {
  const ToldMuscle told = told_muscle(arguments.parameters, arguments.preset);
  palpation::PalpationParameters parameters = told.parameters;
  PressScript script = arguments.script;
  if (const auto segment = palpation::segment_from_name(arguments.segment)) {
    script.segment = *segment;
    script.long_axis = long_axis_of(*segment);
  }
  std::optional<atlas::Atlas> package;
  std::optional<AtlasVentricle> ventricle;
  if (!told.regions.empty() && arguments.package.empty()) {
    throw_invalid(arguments.parameters + ": /regions are found on an atlas's wall; name a package");
  }
  if (!arguments.package.empty()) {
    const std::string& file = arguments.package;
    package = atlas::Atlas::open(file, needs_of_press(atlas::Atlas::open(file, {}).manifest()));
    ventricle = ventricle_of(*package, told, file);
    if (ventricle) parameters.infarct = ventricle->tissue.infarct;
    scale_to_atlas(parameters, package->manifest(), file);
    if (ventricle && arguments.segment.empty()) {
      script.segment = reachable_segment(*package, *ventricle->wall);
      script.long_axis = long_axis_of(script.segment);
    }
  }
  if (arguments.heart_rate_per_min > 0) {
    parameters.circulation.heart_rate_per_min = arguments.heart_rate_per_min;
    parameters.circulation.reference_volume_ml =
        palpation::natural_beat(parameters.whole_circulation()).edv_ml;
  }
  const Press press = run_press(parameters, script);
  const std::vector<TissueForce> tissues = compare_tissues(script);
  std::optional<AtlasPress> on_atlas;
  if (package) on_atlas = press_on_atlas(*package, parameters, press.script, ventricle);
  nlohmann::json json = press_json(press, tissues);
  if (on_atlas) json["atlas"] = atlas_press_json(*on_atlas);
  write_press(press, tissues, arguments.folder);
  write_file(std::filesystem::path(arguments.folder) / "press.json", json_text(json, 2) + "\n");
  if (on_atlas) write_atlas_press(*on_atlas, arguments.folder);
  if (arguments.json) {
    out << json_text(json, 2) << '\n';
  } else {
    out << press_text(press, tissues);
    if (on_atlas) out << atlas_press_text(*on_atlas);
  }
}

}  // namespace beatlas::app
