#include <algorithm>
#include <cmath>

#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/VolumeToMesh.h>

#include "pipeline/field/interpolant.h"
#include "pipeline/field/surface.h"

namespace beatlas::field {
namespace {

// The samples with one layer of outside around them, so that every surface closes: a shape that
// reaches the border ends half a voxel beyond it.
openvdb::FloatGrid::Ptr padded(const Grid& grid, const std::vector<float>& level) {
  const openvdb::CoordBBox box(openvdb::Coord(-1),
                               openvdb::Coord(grid.size[0], grid.size[1], grid.size[2]));
  openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box);
  float* out = dense.data();
  for (int k = -1; k <= grid.size[2]; ++k) {
    for (int j = -1; j <= grid.size[1]; ++j) {
      for (int i = -1; i <= grid.size[0]; ++i) {
        const float nearest = level[grid.offset(std::clamp(i, 0, grid.size[0] - 1),
                                                std::clamp(j, 0, grid.size[1] - 1),
                                                std::clamp(k, 0, grid.size[2] - 1))];
        *out++ = grid.contains(i, j, k) ? nearest : std::abs(nearest);
      }
    }
  }
  const float outside = *std::max_element(level.begin(), level.end());
  openvdb::FloatGrid::Ptr tree = openvdb::FloatGrid::create(outside);
  openvdb::tools::copyFromDense(dense, *tree, 0.0F);
  return tree;
}

}  // namespace

TriangleSoup level_surface(const Grid& grid, const std::vector<float>& level) {
  const auto [least, most] = std::minmax_element(level.begin(), level.end());
  if (level.empty() || *least >= 0 || *most < 0) return {};

  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(*padded(grid, level), points, quads);

  const double spacing_mm = grid.spacing_mm().x();
  const Interpolant interpolant(grid, level);
  // A dual vertex lies within a voxel of the zero it stands for; one that would go further is at
  // a crease or a thin place, where the contour's own guess is the better one.
  const auto on_zero = [&](const Vec3& guess) -> Vec3 {
    const Vec3 found = interpolant.project_to_zero(guess, 0.25 * spacing_mm);
    return (found - guess).norm() < 0.5 * spacing_mm ? found : guess;
  };

  TriangleSoup out;
  out.points.reserve(points.size() + quads.size());
  for (const openvdb::Vec3s& p : points) {
    out.points.push_back(on_zero(grid.mm(static_cast<double>(p.x()), static_cast<double>(p.y()),
                                         static_cast<double>(p.z()))));
  }
  out.triangles.reserve(quads.size() * 4);
  for (const openvdb::Vec4I& quad : quads) {
    const Vec3 middle = 0.25 * (out.points[quad[0]] + out.points[quad[1]] + out.points[quad[2]] +
                                out.points[quad[3]]);
    const auto centre = static_cast<std::uint32_t>(out.points.size());
    out.points.push_back(on_zero(middle));
    for (int side = 0; side < 4; ++side) {
      out.triangles.push_back({quad[side], quad[(side + 1) % 4], centre});
    }
  }
  return out;
}

}  // namespace beatlas::field
