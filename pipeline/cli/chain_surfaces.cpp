// The mesh stage, and surfaces of the package: what it made, in the levels of detail of the scene.
#include <algorithm>
#include <atomic>

#include "pipeline/cli/chain.h"
#include "pipeline/core/parallel.h"
#include "pipeline/mesh/beyond_base.h"
#include "pipeline/mesh/levels.h"
#include "pipeline/mesh/nested.h"
#include "pipeline/mesh/surface_map.h"
#include "runtime/atlas/scene.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
using study::Stage;
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

/// What `make` makes of the field that a structure is meshed by.
template <class Make>
SurfaceCycle on_meshed(const FieldCycle& field, const std::vector<FieldCycle>& all, double edge_mm,
                       const Make& make) {
  return is_beyond_base(field.structure) ? make(mesh::without_ventricles(field, all, edge_mm))
                                         : make(field);
}

/// Makes the surface of each structure, several at a time, for parts of the work on one are a
/// single thread's. What they say comes structure by structure.
template <class Of, class Make>
std::vector<std::optional<SurfaceCycle>> made_of(const std::vector<Of>& all, double share,
                                                 const StageContext& context, const Make& make) {
  struct Making {
    std::optional<SurfaceCycle> surface;
    std::vector<std::string> warnings;
    std::atomic<double> done{0};
  };
  std::vector<Making> making(all.size());
  parallel_for(all.size(), [&](std::size_t n) {
    StageContext own = context;
    own.warn_sink = [&](std::string_view line) { making[n].warnings.emplace_back(line); };
    own.progress_sink = [&](double done, std::string_view step) {
      making[n].done = done;
      double sum = 0;
      for (const Making& each : making) sum += each.done;
      context.part(0, share, structure_name(all[n].structure))
          .progress(sum / static_cast<double>(all.size()), step);
    };
    own.check_cancelled();
    making[n].surface = make(all[n], own);
  });
  std::vector<std::optional<SurfaceCycle>> out;
  for (Making& each : making) {
    for (const std::string& line : each.warnings) context.warn(line);
    out.push_back(std::move(each.surface));
  }
  return out;
}

}  // namespace

void Chain::surfaces() {
  if (keeps(Stage::Mesh, wanted_of(Stage::Mesh, orders_))) return;
  run(Stage::Mesh, [&](StageContext& context) {
    const mesh::MeshOptions& options = orders_.recipe.mesh;
    const auto make = [&](const FieldCycle& field, StageContext& own) {
      return on_meshed(field, field_cycles(), options.edge_mm, [&](const FieldCycle& meshed) {
        return mesh::mesh_cycle(meshed, options, own);
      });
    };
    std::vector<SurfaceCycle> made;
    for (auto& surface : made_of(field_cycles(), kMade, context, make)) {
      made.push_back(std::move(*surface));
    }
    mesh::part_structures(made, field_cycles());
    surfaces_ = std::move(made);
    maps_ = maps_of(*surfaces_);
    context.progress(kMade, "files of the study");
    leave(Stage::Mesh, new_record(Stage::Mesh), [&] {
      study::FileList files = study::write_surfaces(study_->folder(), *surfaces_);
      const study::FileList maps = study::write_surface_maps(study_->folder(), *maps_);
      files.insert(files.end(), maps.begin(), maps.end());
      return files;
    });
  });
}

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
  mesh::MeshOptions options = orders_.recipe.mesh;
  options.edge_mm = edge_mm;
  const std::vector<FieldCycle>& fields = field_cycles();
  const auto make = [&](const SurfaceCycle& each,
                        StageContext& own) -> std::optional<SurfaceCycle> {
    try {
      return on_meshed(of(fields, each.structure), fields, edge_mm, [&](const FieldCycle& meshed) {
        return mesh::level_of_detail(each, meshed, options, own);
      });
    } catch (const Error& error) {
      if (error.code() != ErrorCode::Quality || finest) throw;
      own.warn(std::string(error.what()) + "; the package has no such level of it");
      return std::nullopt;
    }
  };
  std::vector<SurfaceCycle> out;
  for (auto& surface : made_of(made, 1, context, make)) {
    if (surface) out.push_back(std::move(*surface));
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
