#include "runtime/app/ventricle.h"

#include <algorithm>
#include <string>

#include <nlohmann/json.hpp>

#include "runtime/app/region_maps.h"
#include "runtime/app/text.h"
#include "runtime/base/error.h"
#include "runtime/palpation/on_heart.h"

namespace beatlas::app {

atlas::Needs needs_of_press(const atlas::Manifest& manifest) {
  atlas::Needs needs{.fields = {Structure::Heart}, .surfaces = {}};
  const atlas::Needs all = atlas::everything_in(manifest);
  if (all.maps.contains(Structure::LvBlood) && all.surfaces.contains(Structure::LvBlood)) {
    needs.surfaces.insert(Structure::LvBlood);
    needs.maps.insert(Structure::LvBlood);
  } else if (all.fields.contains(Structure::LvBlood)) {
    needs.fields.insert(Structure::LvBlood);
  }
  return needs;
}

ToldMuscle told_muscle(const std::string& file, const std::string& preset) {
  if (!file.empty() && !preset.empty()) {
    throw Error(ErrorCode::Usage,
                "--parameters and --preset both name parameters; give one of them");
  }
  ToldMuscle out;
  if (!preset.empty()) out.parameters = palpation::palpation_preset(preset);
  if (file.empty()) return out;
  const nlohmann::json document = read_json_file(file);
  out.file = file;
  try {
    out.parameters = palpation::palpation_from_json(document);
    if (document.contains("regions")) {
      out.regions = palpation::regions_from_json(document["regions"]);
    }
  } catch (const Error& error) {
    throw error.with_context(file);
  }
  return out;
}

std::optional<AtlasVentricle> ventricle_of(const atlas::Atlas& atlas, const ToldMuscle& told,
                                           const std::string& package) {
  const auto wall = palpation::lv_wall_of(atlas);
  if (!wall) {
    if (told.regions.empty()) return std::nullopt;
    throw_invalid(package + " has no map of the LV's wall, which the regions of " +
                  told.file.string() + " are found on; build it again from images");
  }
  const palpation::RegionMaps maps = read_region_maps(told.regions, told.file.parent_path(), *wall,
                                                      atlas.manifest().workspace_from_lps);
  return AtlasVentricle{
      wall, palpation::tissue_of_wall(*wall, told.parameters.segments, told.regions, maps)};
}

void scale_to_atlas(palpation::PalpationParameters& parameters, const atlas::Manifest& manifest,
                    const std::string& package) {
  for (const atlas::StructureEntry& structure : manifest.structures) {
    if (structure.name != "lv_blood") continue;
    const auto [least, most] =
        std::minmax_element(structure.volume_ml.begin(), structure.volume_ml.end());
    try {
      parameters = palpation::on_heart(
          parameters,
          {.edv_ml = *most, .esv_ml = *least, .heart_rate_per_min = 60 / manifest.rr_interval_s});
    } catch (const Error& error) {
      throw error.with_context(package);
    }
    return;
  }
  throw_invalid(package + " holds no volumes of lv_blood; build it with a scene that has them");
}

}  // namespace beatlas::app
