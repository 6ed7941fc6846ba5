#include "runtime/app/press_session.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <ostream>

#include <nlohmann/json.hpp>

#include "runtime/app/atlas_press.h"
#include "runtime/app/painted_map.h"
#include "runtime/app/text.h"
#include "runtime/base/error.h"
#include "runtime/palpation/fit.h"

namespace beatlas::app {
namespace {

using palpation::PalpationParameters;

struct Given {
  PalpationParameters parameters;
  std::vector<palpation::Region> regions;
};

Given parameters_from_file(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw_invalid(file + " cannot be read; check its name and rights");
  const auto document = nlohmann::json::parse(stream, nullptr, false, true);
  if (document.is_discarded()) throw_invalid(file + " is not valid JSON");
  try {
    Given out{palpation::palpation_from_json(document), {}};
    if (document.contains("regions")) {
      out.regions = palpation::regions_from_json(document["regions"]);
    }
    return out;
  } catch (const Error& error) {
    throw error.with_context(file);
  }
}

// The atlas's own left ventricle: its volumes and its heart rate.
void scale_to_atlas(PalpationParameters& parameters, const atlas::Manifest& manifest,
                    const std::string& package) {
  for (const atlas::StructureEntry& structure : manifest.structures) {
    if (structure.name != "lv_blood") continue;
    const auto [least, most] =
        std::minmax_element(structure.volume_ml.begin(), structure.volume_ml.end());
    try {
      parameters.circulation = palpation::fit_to_heart(parameters.whole_circulation(), *most,
                                                       *least, 60 / manifest.rr_interval_s);
    } catch (const Error& error) {
      throw error.with_context(package);
    }
    return;
  }
  throw_invalid(package + " holds no volumes of lv_blood; build it with a scene that has them");
}

// The middle of a segment's ring, for a ventricle without a map.
double long_axis_of(int segment) {
  if (segment == palpation::kSegments) return 0.04;
  return segment <= 6 ? 5.0 / 6 : segment <= 12 ? 0.5 : 1.0 / 6;
}

// Which muscle of the atlas is ill: that of the segments and regions, on its own wall.
std::optional<AtlasVentricle> ventricle_of(const atlas::Atlas& package,
                                           const PalpationParameters& parameters,
                                           const std::vector<palpation::Region>& regions,
                                           const PressArguments& arguments) {
  const auto wall = wall_of(package);
  if (!wall) {
    if (regions.empty()) return std::nullopt;
    throw_invalid(arguments.package + " has no map of the LV's wall, which the regions of " +
                  arguments.parameters + " are found on; build it again from images");
  }
  const palpation::PaintedMaps painted =
      read_painted_maps(regions, std::filesystem::path(arguments.parameters).parent_path(), *wall);
  return AtlasVentricle{wall,
                        palpation::tissue_of_wall(*wall, parameters.segments, regions, painted)};
}

}  // namespace

void run_press_session(const PressArguments& arguments, std::ostream& out) {
  PalpationParameters parameters;
  std::vector<palpation::Region> regions;
  if (!arguments.parameters.empty()) {
    Given given = parameters_from_file(arguments.parameters);
    parameters = given.parameters;
    regions = std::move(given.regions);
  }
  if (!arguments.preset.empty()) parameters = palpation::palpation_preset(arguments.preset);
  PressScript script = arguments.script;
  if (const auto segment = palpation::segment_from_name(arguments.segment)) {
    script.segment = *segment;
    script.long_axis = long_axis_of(*segment);
  }
  std::optional<atlas::Atlas> package;
  std::optional<AtlasVentricle> ventricle;
  if (!regions.empty() && arguments.package.empty()) {
    throw_invalid(arguments.parameters + ": /regions are found on an atlas's wall; name a package");
  }
  if (!arguments.package.empty()) {
    const std::string& file = arguments.package;
    package = atlas::Atlas::open(file, needs_of_press(atlas::Atlas::open(file, {}).manifest()));
    ventricle = ventricle_of(*package, parameters, regions, arguments);
    if (ventricle) parameters.infarct = ventricle->tissue.infarct;
    scale_to_atlas(parameters, package->manifest(), file);
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
  write_file(std::filesystem::path(arguments.folder) / "press.json", json.dump(2) + "\n");
  if (on_atlas) write_atlas_press(*on_atlas, arguments.folder);
  if (arguments.json) {
    out << json.dump(2) << '\n';
  } else {
    out << press_text(press, tissues);
    if (on_atlas) out << atlas_press_text(*on_atlas);
  }
}

}  // namespace beatlas::app
