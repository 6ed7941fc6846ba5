#include "pipeline/cli/source_labels.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <set>

#include "pipeline/core/parallel.h"
#include "pipeline/field/surface_rows.h"
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

/// A field that is asked for labels.
struct AskedField {
  field::FieldQuery query;
  Structure structure;
  Region region;
};

/// Takes note of a voxel that lies in a structure.
/// @param depth_mm negative  @param deepest_mm of the structures there so far, the heart aside
void label_voxel(Structure structure, double depth_mm, std::uint8_t& label, double& deepest_mm) {
  if (structure == Structure::Heart) {
    if (label == kLabelBackground) label = kLabelRestOfHeart;
  } else if (depth_mm < deepest_mm) {
    deepest_mm = depth_mm;
    label = label_of(structure);
  }
}

/// Of slice k at time t_s: where the field's structure is deeper than what is there.
/// @param deepest_mm of the slice's voxels  @param out labels of the phase
void label_slice(const AskedField& asked, int k, double t_s, const Grid& lps_grid,
                 const Affine& workspace_from_index, std::vector<double>& deepest_mm,
                 std::vector<std::uint8_t>& out) {
  const Region& region = asked.region;
  if (k < region.first[2] || k >= region.end[2]) return;
  for (int j = region.first[1]; j < region.end[1]; ++j) {
    for (int i = region.first[0]; i < region.end[0]; ++i) {
      const double d = asked.query.sample(workspace_from_index * Vec3(i, j, k), t_s).distance_mm;
      if (d >= 0) continue;
      const std::size_t at = lps_grid.offset(i, j, k);
      const std::size_t in_slice = at - lps_grid.offset(0, 0, k);
      label_voxel(asked.structure, d, out[at], deepest_mm[in_slice]);
    }
  }
}

/// Of one phase: where the surface's label is more than what is there says.
void label_inside(const atlas::SurfacePayload& surface, std::size_t phase, const Grid& lps_grid,
                  const Affine& lps_from_workspace, std::vector<std::uint8_t>& out) {
  field::TriangleSoup soup;
  soup.triangles = surface.triangles;
  soup.points.reserve(surface.positions[phase].size());
  for (const Vec3f& mm : surface.positions[phase]) {
    soup.points.push_back(lps_from_workspace * mm.cast<double>());
  }
  const auto rows = field::row_crossings(soup, lps_grid);
  const std::uint8_t label = label_of(surface.structure);
  for (int k = 0; k < lps_grid.size[2]; ++k) {
    for (int j = 0; j < lps_grid.size[1]; ++j) {
      const std::vector<double>& row =
          rows[static_cast<std::size_t>(j) +
               static_cast<std::size_t>(lps_grid.size[1]) * static_cast<std::size_t>(k)];
      std::size_t passed = 0;
      for (int i = 0; i < lps_grid.size[0]; ++i) {
        while (passed < row.size() && row[passed] <= i) ++passed;
        if (passed % 2 == 0) continue;
        std::uint8_t& voxel = out[lps_grid.offset(i, j, k)];
        if (voxel == kLabelBackground || voxel == kLabelRestOfHeart) voxel = label;
      }
    }
  }
}

int phases_of(const Shapes& shapes) {
  std::set<std::size_t> phases;
  for (const auto& field : shapes.fields) phases.insert(static_cast<std::size_t>(field->phases));
  for (const auto& surface : shapes.surfaces) phases.insert(surface->positions.size());
  if (phases.empty()) throw_invalid("there is no distance field or surface to take labels from");
  if (phases.size() > 1) throw_invalid("the distance fields and surfaces differ in their phases");
  return static_cast<int>(*phases.begin());
}

}  // namespace

LabelCycle labels_from_shapes(const Shapes& shapes, const Grid& lps_grid,
                              const Affine& workspace_from_lps, double rr_interval_s,
                              StageContext& context) {
  const int phases = phases_of(shapes);
  const Affine workspace_from_index = workspace_from_lps * lps_grid.mm_from_index;
  std::vector<AskedField> fields;
  for (const auto& payload : shapes.fields) {
    fields.push_back({field::FieldQuery(payload, rr_interval_s), payload->structure,
                      region_of(*payload, lps_grid, workspace_from_index)});
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
    std::vector<double> deepest_mm(lps_grid.slice_count(), 0.0);
    for (const AskedField& asked : fields) {
      label_slice(asked, k, t_s, lps_grid, workspace_from_index, deepest_mm, out);
    }
    context.progress(static_cast<double>(++done) / static_cast<double>(slabs));
  });
  const Affine lps_from_workspace = workspace_from_lps.inverse();
  parallel_for(labels.phases.size(), [&](std::size_t phase) {
    for (const auto& surface : shapes.surfaces) {
      context.check_cancelled();
      label_inside(*surface, phase, lps_grid, lps_from_workspace, labels.phases[phase]);
    }
  });
  return labels;
}

}  // namespace beatlas::cli
