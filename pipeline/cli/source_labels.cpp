#include "pipeline/cli/source_labels.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "runtime/base/error.h"
#include "runtime/field/field_query.h"

namespace beatlas::cli {
namespace {

struct Region {
  Index3 first;
  Index3 end;
};

/// The voxels of the grid whose centres can lie in the lattice of a field.
Region region_of(const atlas::FieldPayload& field, const Grid& grid,
                 const Affine& workspace_from_index) {
  const Affine index_from_workspace = workspace_from_index.inverse();
  Vec3 low = Vec3::Constant(1e9);
  Vec3 high = Vec3::Constant(-1e9);
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 at = field.origin_mm;
    for (int axis = 0; axis < 3; ++axis) {
      if ((corner >> axis & 1) != 0) {
        at[axis] += field.voxel_mm * atlas::FieldPayload::kBlockEdge *
                    field.block_count[static_cast<std::size_t>(axis)];
      }
    }
    const Vec3 index = index_from_workspace * at;
    low = low.cwiseMin(index);
    high = high.cwiseMax(index);
  }
  Region region{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const double size = grid.size[axis];
    region.first[axis] = static_cast<int>(std::clamp(std::floor(low[a]), 0.0, size));
    region.end[axis] = static_cast<int>(std::clamp(std::ceil(high[a]) + 1, 0.0, size));
  }
  return region;
}

}  // namespace

LabelCycle labels_from_fields(const std::vector<std::shared_ptr<const atlas::FieldPayload>>& fields,
                              const Grid& lps_grid, const Affine& workspace_from_lps,
                              double rr_interval_s, StageContext& context) {
  if (fields.empty()) throw_invalid("there is no distance field to take labels from");
  const int phases = fields.front()->phases;
  const Affine workspace_from_index = workspace_from_lps * lps_grid.mm_from_index;
  std::vector<field::FieldQuery> queries;
  std::vector<Region> regions;
  for (const auto& payload : fields) {
    if (payload->phases != phases) throw_invalid("the distance fields differ in their phases");
    queries.emplace_back(payload, rr_interval_s);
    regions.push_back(region_of(*payload, lps_grid, workspace_from_index));
  }
  LabelCycle labels;
  labels.grid = lps_grid;
  labels.phases.assign(static_cast<std::size_t>(phases),
                       std::vector<std::uint8_t>(lps_grid.count(), kLabelBackground));
  const auto slices = static_cast<std::size_t>(lps_grid.size[2]);
  std::atomic<std::size_t> done{0};
  const std::size_t slabs = slices * static_cast<std::size_t>(phases);
  parallel_for(slabs, [&](std::size_t slab) {
    context.check_cancelled();
    const std::size_t phase = slab / slices;
    const int k = static_cast<int>(slab % slices);
    const double t_s = rr_interval_s * static_cast<double>(phase) / phases;
    std::vector<std::uint8_t>& out = labels.phases[phase];
    std::vector<double> deepest(lps_grid.slice_count(), 0.0);
    for (std::size_t f = 0; f < fields.size(); ++f) {
      const Structure structure = fields[f]->structure;
      const Region& region = regions[f];
      if (k < region.first[2] || k >= region.end[2]) continue;
      for (int j = region.first[1]; j < region.end[1]; ++j) {
        for (int i = region.first[0]; i < region.end[0]; ++i) {
          const double d = queries[f].sample(workspace_from_index * Vec3(i, j, k), t_s).distance_mm;
          if (d >= 0) continue;
          const std::size_t at = lps_grid.offset(i, j, k);
          const std::size_t in_slice = at - lps_grid.offset(0, 0, k);
          if (structure == Structure::Heart) {
            if (out[at] == kLabelBackground) out[at] = kLabelRestOfHeart;
          } else if (d < deepest[in_slice]) {
            deepest[in_slice] = d;
            out[at] = label_of(structure);
          }
        }
      }
    }
    context.progress(static_cast<double>(++done) / static_cast<double>(slabs));
  });
  return labels;
}

}  // namespace beatlas::cli
