#include "pipeline/build/surfaces.h"

#include <algorithm>
#include <atomic>
#include <string>
#include <utility>

#include "pipeline/build/scene_plan.h"
#include "pipeline/core/parallel.h"
#include "pipeline/mesh/levels.h"
#include "pipeline/mesh/nested.h"
#include "pipeline/study/state.h"
#include "runtime/atlas/scene.h"
#include "runtime/base/error.h"

namespace beatlas::build {
namespace {

/// Makes the surface of each structure, several at a time, for parts of the work on one are a
/// single thread's. What they say comes structure by structure.
template <class Of, class Make>
std::vector<std::optional<SurfaceCycle>> made_of(const std::vector<const Of*>& all,
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
      context.part(0, 1, structure_name(all[n]->structure))
          .progress(sum / static_cast<double>(all.size()), step);
    };
    own.check_cancelled();
    making[n].surface = make(*all[n], own);
  });
  std::vector<std::optional<SurfaceCycle>> out;
  for (Making& each : making) {
    for (const std::string& line : each.warnings) context.warn(line);
    out.push_back(std::move(each.surface));
  }
  return out;
}

}  // namespace

std::vector<SurfaceCycle> make_surfaces(const std::vector<FieldCycle>& fields,
                                        const std::vector<Structure>& of,
                                        const mesh::MeshOptions& options,
                                        const StageContext& context) {
  std::vector<const FieldCycle*> asked;
  for (const FieldCycle& field : fields) {
    if (is_among(field.structure, of)) asked.push_back(&field);
  }
  const auto make = [&](const FieldCycle& field, StageContext& own) {
    return mesh::mesh_cycle(field, options, own);
  };
  std::vector<SurfaceCycle> made;
  for (auto& surface : made_of(asked, context, make)) made.push_back(std::move(*surface));
  return made;
}

std::vector<Structure> edited_surfaces(const study::Study& study) {
  const std::vector<std::string> edited = study::edited_outputs(study, study::Stage::Mesh);
  std::vector<Structure> out;
  for (const Structure structure : kAllStructures) {
    const std::string prefix = "mesh/" + std::string(structure_name(structure)) + "_";
    const bool any = std::any_of(edited.begin(), edited.end(),
                                 [&](const std::string& file) { return file.starts_with(prefix); });
    if (any) out.push_back(structure);
  }
  return out;
}

std::vector<SurfaceCycle> surfaces_at_level(const std::vector<SurfaceCycle>& made,
                                            const std::vector<FieldCycle>& fields,
                                            mesh::MeshOptions options, double edge_mm, bool finest,
                                            const StageContext& context) {
  options.edge_mm = edge_mm;
  const auto make = [&](const SurfaceCycle& each,
                        StageContext& own) -> std::optional<SurfaceCycle> {
    const auto field = std::find_if(fields.begin(), fields.end(), [&](const FieldCycle& candidate) {
      return candidate.structure == each.structure;
    });
    try {
      return mesh::level_of_detail(each, *field, options, own);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::Quality || finest) throw;
      own.warn(std::string(error.what()) + "; the package has no such level of it");
      return std::nullopt;
    }
  };
  std::vector<const SurfaceCycle*> all;
  for (const SurfaceCycle& each : made) all.push_back(&each);
  std::vector<SurfaceCycle> out;
  for (auto& surface : made_of(all, context, make)) {
    if (surface) out.push_back(std::move(*surface));
  }
  mesh::part_structures(out, fields);
  return out;
}

std::vector<SurfaceMap> make_maps(const std::vector<FieldCycle>& fields,
                                  const std::vector<SurfaceCycle>& surfaces,
                                  const std::optional<mesh::MapFrame>& frame) {
  std::vector<SurfaceMap> maps;
  if (!frame) return maps;
  for (const SurfaceCycle& surface : surfaces) {
    if (!atlas::kind_exists(atlas::kMapKind, surface.structure)) continue;
    auto map = mesh::surface_map(surface.structure, fields, surfaces, *frame);
    if (map) maps.push_back(std::move(*map));
  }
  return maps;
}

}  // namespace beatlas::build
