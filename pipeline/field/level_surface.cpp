#include <algorithm>
#include <cmath>
#include <optional>

#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>

#include "pipeline/field/interpolant.h"
#include "pipeline/field/surface.h"

namespace beatlas::field {
namespace {

using Tree = openvdb::FloatTree;
using Leaf = Tree::LeafNodeType;
constexpr int kLeafEdge = static_cast<int>(Leaf::DIM);

// The samples with one layer of outside around them, so that every surface closes: a shape that
// reaches the border ends half a voxel beyond it.
class Padded {
 public:
  Padded(const Grid& grid, const std::vector<float>& level) : grid_(grid), level_(level) {}

  float operator()(int i, int j, int k) const {
    const float nearest = level_[grid_.offset(std::clamp(i, 0, grid_.size[0] - 1),
                                              std::clamp(j, 0, grid_.size[1] - 1),
                                              std::clamp(k, 0, grid_.size[2] - 1))];
    return grid_.contains(i, j, k) ? nearest : std::abs(nearest);
  }

  // Whether block `at` of the tree and the layer of samples around it are all on one side, and of
  // the block's samples on which.
  std::optional<bool> side(const openvdb::Coord& at) const {
    bool any_inside = false;
    bool any_outside = false;
    for (int k = at.z() - 1; k <= at.z() + kLeafEdge; ++k) {
      for (int j = at.y() - 1; j <= at.y() + kLeafEdge; ++j) {
        if (k < 0 || j < 0 || k >= grid_.size[2] || j >= grid_.size[1]) {
          any_outside = true;
          continue;
        }
        const float* row = level_.data() + grid_.offset(0, j, k);
        const int first = std::max(at.x() - 1, 0);
        const int last = std::min(at.x() + kLeafEdge, grid_.size[0] - 1);
        any_outside = any_outside || first > at.x() - 1 || last < at.x() + kLeafEdge;
        float least = row[first];
        float most = row[first];
        for (int i = first; i <= last; ++i) {
          least = std::min(least, row[i]);
          most = std::max(most, row[i]);
        }
        any_inside = any_inside || least < 0;
        any_outside = any_outside || most >= 0;
      }
      if (any_inside && any_outside) return std::nullopt;
    }
    return any_inside;
  }

  void copy_to(Leaf& leaf) const {
    const openvdb::Coord at = leaf.origin();
    for (int i = 0; i < kLeafEdge; ++i) {
      for (int j = 0; j < kLeafEdge; ++j) {
        for (int k = 0; k < kLeafEdge; ++k) {
          const openvdb::Coord to = at + openvdb::Coord(i, j, k);
          leaf.setValueOn(Leaf::coordToOffset(to), (*this)(to.x(), to.y(), to.z()));
        }
      }
    }
  }

 private:
  const Grid& grid_;
  const std::vector<float>& level_;
};

// The samples about the level's zero; of the rest the tree knows the side.
openvdb::FloatGrid::Ptr sides(const Grid& grid, const std::vector<float>& level) {
  openvdb::FloatGrid::Ptr out = openvdb::FloatGrid::create(1.0F);
  const Padded padded(grid, level);
  for (int k = -kLeafEdge; k <= grid.size[2]; k += kLeafEdge) {
    for (int j = -kLeafEdge; j <= grid.size[1]; j += kLeafEdge) {
      for (int i = -kLeafEdge; i <= grid.size[0]; i += kLeafEdge) {
        const openvdb::Coord at(i, j, k);
        const std::optional<bool> inside = padded.side(at);
        if (!inside) {
          padded.copy_to(*out->tree().touchLeaf(at));
        } else if (*inside) {
          out->tree().addTile(1, at, -1.0F, false);
        }
      }
    }
  }
  return out;
}

}  // namespace

TriangleSoup level_surface(const Grid& grid, const std::vector<float>& level) {
  const auto [least, most] = std::minmax_element(level.begin(), level.end());
  if (level.empty() || *least >= 0 || *most < 0) return {};

  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(*sides(grid, level), points, quads);

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
