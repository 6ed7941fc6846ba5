#include "pipeline/cli/stored_distances.h"

#include "pipeline/core/parallel.h"
#include "runtime/field/field_query.h"

namespace beatlas::cli {

FieldCycle distances_of(const std::shared_ptr<const atlas::FieldPayload>& field,
                        std::vector<double> volume_ml) {
  FieldCycle out;
  out.structure = field->structure;
  out.voxel_mm = field->voxel_mm;
  out.inner_mm = field->inner_mm;
  out.outer_mm = field->outer_mm;
  out.volume_ml = std::move(volume_ml);
  Grid& grid = out.distance_mm.grid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grid.size[axis] = atlas::FieldPayload::kBlockEdge * field->block_count[axis];
  }
  grid.mm_from_index.linear() = field->voxel_mm * Eigen::Matrix3d::Identity();
  grid.mm_from_index.translation() = field->origin_mm;
  const auto phases = static_cast<std::size_t>(field->phases);
  out.distance_mm.phases.assign(phases, std::vector<float>(grid.count()));
  const field::FieldQuery query(field, 1.0);
  const auto slices = static_cast<std::size_t>(grid.size[2]);
  parallel_for(phases * slices, [&](std::size_t slab) {
    const std::size_t phase = slab / slices;
    const int k = static_cast<int>(slab % slices);
    const double t = static_cast<double>(phase) / static_cast<double>(phases);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        out.distance_mm.phases[phase][grid.offset(i, j, k)] =
            static_cast<float>(query.sample(grid.mm(i, j, k), t).distance_mm);
      }
    }
  });
  return out;
}

}  // namespace beatlas::cli
