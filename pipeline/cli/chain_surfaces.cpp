// Surfaces of the package: what the mesh stage made, in the levels of detail of the scene.
#include <algorithm>

#include "pipeline/cli/chain.h"
#include "pipeline/mesh/levels.h"
#include "pipeline/mesh/nested.h"
#include "pipeline/mesh/surface_map.h"
#include "runtime/atlas/scene.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace {

template <class Cycle>
const Cycle& of(const std::vector<Cycle>& cycles, Structure structure) {
  return *std::find_if(cycles.begin(), cycles.end(),
                       [&](const Cycle& each) { return each.structure == structure; });
}

nlohmann::json error_figures(const FieldCycle& field, const SurfaceCycle& surface, int level) {
  const mesh::SurfaceError error = mesh::error_against(field, surface);
  return {{"structure", structure_name(surface.structure)}, {"level", level},
          {"vertices", surface.positions.front().size()},   {"mean_mm", error.mean_mm},
          {"worst_phase_mm", error.worst_phase_mm},         {"bias_mm", error.bias_mm}};
}

}  // namespace

std::vector<SurfaceMap> Chain::maps_of(const std::vector<SurfaceCycle>& surfaces) {
  const std::optional<LongAxis> axis =
      study_ ? study::read_long_axis(study_->folder()) : facts_.axis;
  const auto rv = std::find_if(surfaces.begin(), surfaces.end(), [](const SurfaceCycle& surface) {
    return surface.structure == Structure::RvBlood;
  });
  if (!axis || rv == surfaces.end()) return {};
  Vec3 centre = Vec3::Zero();
  for (const Vec3f& x : rv->positions.front()) centre += x.cast<double>();
  centre /= static_cast<double>(rv->positions.front().size());
  const Affine map =
      study_ ? study::read_workspace_from_lps(study_->folder()) : facts_.workspace_from_lps.value();
  return mesh::surface_maps(field_cycles(), surfaces, mesh::lv_frame(*axis, map, centre));
}

std::vector<SurfaceCycle> Chain::at_level(const std::vector<SurfaceCycle>& made, double edge_mm,
                                          bool finest, const StageContext& context) {
  std::vector<SurfaceCycle> out;
  for (std::size_t n = 0; n < made.size(); ++n) {
    context.check_cancelled();
    const auto all = static_cast<double>(made.size());
    const auto before = static_cast<double>(n);
    StageContext part =
        context.part(before / all, (before + 1) / all, structure_name(made[n].structure));
    mesh::MeshOptions options = orders_.recipe.mesh;
    options.edge_mm = edge_mm;
    try {
      const FieldCycle& field = of(field_cycles(), made[n].structure);
      out.push_back(mesh::level_of_detail(made[n], field, options, part));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::Quality || finest) throw;
      context.warn(std::string(error.what()) + "; the package has no such level of it");
    }
  }
  mesh::part_structures(out, field_cycles());
  return out;
}

std::vector<SurfaceMap> Chain::maps_beside(const SurfaceCycle& surface) {
  std::vector<SurfaceCycle> around = surface_cycles();
  for (SurfaceCycle& each : around) {
    if (each.structure == surface.structure) each = surface;
  }
  return maps_of(around);
}

void Chain::add_surfaces(const Scene& scene, const std::vector<SurfaceCycle>& used,
                         pack::PackageContent& content, StageContext& context) {
  if (used.empty()) return;
  const double made_mm = orders_.recipe.mesh.edge_mm;
  content.manifest.surface_edges_mm = surface_edges_mm(scene, made_mm);
  const std::vector<double>& edges_mm = content.manifest.surface_edges_mm;
  nlohmann::json figures = nlohmann::json::array();
  for (std::size_t n = 0; n < edges_mm.size(); ++n) {
    const auto each = static_cast<double>(edges_mm.size());
    const auto before = static_cast<double>(n);
    StageContext part = context.part(before / each, (before + 1) / each);
    const bool as_made = edges_mm[n] == made_mm;
    std::vector<SurfaceCycle> level = as_made ? used : at_level(used, edges_mm[n], n == 0, part);
    for (SurfaceCycle& surface : level) {
      std::vector<SurfaceMap> maps;
      if (atlas::kind_exists(atlas::kMapKind, surface.structure)) {
        maps = as_made ? surface_maps() : maps_beside(surface);
      }
      figures.push_back(
          error_figures(of(field_cycles(), surface.structure), surface, static_cast<int>(n)));
      for (SurfaceMap& map : maps) {
        if (map.structure != surface.structure) continue;
        content.maps.push_back({map.structure, std::move(map.long_axis), std::move(map.angle_rad),
                                std::move(map.segment), std::move(map.thickness_mm),
                                static_cast<int>(n)});
      }
      content.surfaces.push_back({surface.structure, std::move(surface.triangles),
                                  std::move(surface.positions), static_cast<int>(n)});
    }
  }
  content.manifest.provenance["surfaces"] = std::move(figures);
}

}  // namespace beatlas::cli
