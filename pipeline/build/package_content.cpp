#include "pipeline/build/package_content.h"

#include <algorithm>
#include <string>
#include <utility>

#include "pipeline/build/quality.h"
#include "pipeline/build/scene_plan.h"
#include "pipeline/build/surfaces.h"
#include "pipeline/build/version.h"
#include "pipeline/mesh/levels.h"
#include "pipeline/mesh/nested.h"
#include "pipeline/report/prediction_intervals.h"
#include "runtime/atlas/scene.h"
#include "runtime/base/error.h"

namespace beatlas::build {
using nlohmann::json;
using study::Stage;
namespace {

/// @pre `structure` is among them
template <class Cycle>
const Cycle& of(const std::vector<Cycle>& cycles, Structure structure) {
  return *std::find_if(cycles.begin(), cycles.end(),
                       [&](const Cycle& each) { return each.structure == structure; });
}

json error_figures(const FieldCycle& field, const SurfaceCycle& surface, int level) {
  const mesh::SurfaceError error = mesh::error_against(field, surface);
  return {{"structure", structure_name(surface.structure)}, {"level", level},
          {"vertices", surface.positions.front().size()},   {"mean_mm", error.mean_mm},
          {"worst_phase_mm", error.worst_phase_mm},         {"bias_mm", error.bias_mm}};
}

/// Of the surfaces that were made those of the plan, in order of the fields. They make room for
/// each other, and for no others.
std::vector<SurfaceCycle> surfaces_of_plan(const ScenePlan& plan, const MadeOfExam& made) {
  std::vector<SurfaceCycle> out;
  for (const FieldCycle& field : made.fields) {
    if (!is_among(field.structure, plan.surfaces)) continue;
    const auto surface = std::find_if(
        made.surfaces.begin(), made.surfaces.end(),
        [&](const SurfaceCycle& candidate) { return candidate.structure == field.structure; });
    if (surface == made.surfaces.end()) {
      throw_invalid("there is no surface of " + std::string(structure_name(field.structure)) +
                    ", which the scene needs; run the stage mesh again");
    }
    out.push_back(*surface);
  }
  mesh::part_structures(out, made.fields, made.edited);
  return out;
}

/// The map of `surface`, which stands in place of the one that was made; the wall's other side
/// stays.
std::optional<SurfaceMap> map_beside(const SurfaceCycle& surface, const MadeOfExam& made,
                                     const std::optional<mesh::MapFrame>& frame) {
  if (!frame) return std::nullopt;
  std::vector<SurfaceCycle> around = made.surfaces;
  for (SurfaceCycle& each : around) {
    if (each.structure == surface.structure) each = surface;
  }
  return mesh::surface_map(surface.structure, made.fields, around, *frame);
}

std::optional<SurfaceMap> map_made(Structure structure, const MadeOfExam& made) {
  const auto found = std::find_if(made.maps.begin(), made.maps.end(), [&](const SurfaceMap& map) {
    return map.structure == structure;
  });
  return found == made.maps.end() ? std::nullopt : std::optional(*found);
}

/// The band of a structure, if it is known.
std::optional<atlas::SurfaceBand> band_of(Structure structure, const Facts& facts) {
  const auto segmented = facts.stages.find(Stage::Segment);
  const auto band = facts.bands.find(structure);
  if (segmented == facts.stages.end() || band == facts.bands.end() ||
      !report::is_fitted_to(segmented->second.options)) {
    return std::nullopt;
  }
  return band->second;
}

/// Surfaces of the scene in its levels of detail, with their maps and errors.
void add_surfaces(const Scene& scene, const Recipe& recipe, const Facts& facts,
                  const MadeOfExam& made, const std::vector<SurfaceCycle>& used,
                  pack::PackageContent& content, const StageContext& context) {
  if (used.empty()) return;
  const double made_mm = mesh::triangle_edge_mm(made.fields.front().voxel_mm, recipe.mesh);
  content.manifest.surface_edges_mm = surface_edges_mm(scene, made_mm);
  const std::vector<double>& edges_mm = content.manifest.surface_edges_mm;
  const std::optional<mesh::MapFrame> frame =
      mesh::map_frame(made.axis, *facts.workspace_from_lps, facts.source.spacing_mm());
  json figures = json::array();
  for (std::size_t n = 0; n < edges_mm.size(); ++n) {
    const auto each = static_cast<double>(edges_mm.size());
    const auto before = static_cast<double>(n);
    const StageContext part = context.part(before / each, (before + 1) / each);
    const bool as_made = edges_mm[n] == made_mm;
    std::vector<SurfaceCycle> level =
        as_made ? used
                : surfaces_at_level(used, made.fields, recipe.mesh, edges_mm[n], n == 0, part);
    for (SurfaceCycle& surface : level) {
      std::optional<SurfaceMap> map;
      if (atlas::kind_exists(atlas::kMapKind, surface.structure)) {
        map = as_made ? map_made(surface.structure, made) : map_beside(surface, made, frame);
      }
      figures.push_back(
          error_figures(of(made.fields, surface.structure), surface, static_cast<int>(n)));
      if (map) {
        content.maps.push_back({map->structure, std::move(map->long_axis),
                                std::move(map->angle_rad), std::move(map->segment),
                                std::move(map->thickness_mm), static_cast<int>(n)});
      }
      content.surfaces.push_back({surface.structure, std::move(surface.triangles),
                                  std::move(surface.positions), static_cast<int>(n)});
    }
  }
  content.manifest.provenance["surfaces"] = std::move(figures);
}

json provenance(const ScenePlan& plan, const Recipe& recipe, const Facts& facts,
                const std::vector<Structure>& needed,
                const std::vector<StructureQuality>& quality) {
  json stages = json::object();
  for (const auto& [stage, fact] : facts.stages) {
    stages[std::string(study::stage_name(stage))] = {{"version", fact.version},
                                                     {"options", fact.options}};
  }
  if (!plan.atria && stages.contains("segment")) {
    stages["segment"]["options"]["atria"] = false;
  }
  stages["pack"] = {{"version", kVersion}, {"options", stage_options(recipe, Stage::Pack)}};
  json out{{"program", "beatlas"},
           {"version", kVersion},
           {"stages", stages},
           {"input_sha256", facts.input_sha256},
           {"source_format", facts.source_format},
           {"decisions", facts.decisions},
           {"warnings", facts.warnings},
           {"quality", quality_to_json(quality)},
           {"needs", names_of(needed)}};
  if (!facts.phantom_identity.empty()) out["phantom_identity"] = facts.phantom_identity;
  return out;
}

}  // namespace

json names_of(const std::vector<Structure>& structures) {
  json out = json::array();
  for (const Structure structure : structures) out.push_back(structure_name(structure));
  return out;
}

json volume_figures(const pack::PackedVolume& volume) {
  return {{"noise", volume.noise},
          {"quantum", volume.quantum},
          {"rms_error", volume.rms_error},
          {"psnr_db", volume.psnr_db}};
}

void add_volume(pack::PackedVolume volume, pack::PackageContent& content) {
  content.manifest.provenance["volume"] = volume_figures(volume);
  content.volume = std::move(volume);
}

pack::PackageContent package_content(const Scene& scene, const Recipe& recipe, const Facts& facts,
                                     const std::vector<Structure>& needed, const MadeOfExam& made,
                                     StageContext& context) {
  // A package is the same from a study that holds more than the scene needs.
  const ScenePlan plan = plan_of(scene);
  const std::vector<SurfaceCycle> used = surfaces_of_plan(plan, made);
  std::vector<StructureQuality> quality = measure_quality(facts.volumes, made.fields, used);
  std::erase_if(quality, [&](const StructureQuality& each) {
    return !is_among(each.structure, plan.fields);
  });
  demand_quality(quality, recipe.quality);

  pack::PackageContent content;
  atlas::Manifest& manifest = content.manifest;
  manifest.scene = scene.content;
  manifest.stiffness_n_per_m = scene.stiffness_n_per_m;
  manifest.rr_interval_s = facts.rr_interval_s;
  manifest.frame_times_s = facts.frame_times_s;
  manifest.workspace_from_lps = *facts.workspace_from_lps;
  manifest.source_size = facts.source.size;
  manifest.source_lps_from_index = facts.source.mm_from_index;
  manifest.end_diastole = facts.end_diastole;
  manifest.end_systole = facts.end_systole;
  for (const report::VolumeCurve& curve : facts.volumes) {
    if (is_beyond_base(curve.structure) && !plan.atria) continue;
    manifest.structures.push_back({std::string(structure_name(curve.structure)), curve.volume_ml,
                                   band_of(curve.structure, facts)});
  }
  manifest.provenance = provenance(plan, recipe, facts, needed, quality);
  for (const FieldCycle& field : made.fields) {
    context.check_cancelled();
    if (!atlas::scene_holds(scene.content, atlas::kFieldKind, field.structure)) continue;
    const double share =
        static_cast<double>(content.fields.size()) / static_cast<double>(made.fields.size());
    context.progress(0.6 * share, std::string(structure_name(field.structure)) + ", distances");
    content.fields.push_back(pack::encode_field(field, recipe.pack));
  }
  add_surfaces(scene, recipe, facts, made, used, content, context.part(0.6, 1));
  return content;
}

}  // namespace beatlas::build
