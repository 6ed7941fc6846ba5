#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/field/surface.h"

namespace beatlas::field {

/// Exact distance from a point to the nearest of many triangles: a tree of boxes that lie along
/// the surface, so that deep points, too, see only the few triangles about their foot.
/// Degenerate triangles count as the segments or points they are.
class ClosestTriangle {
 public:
  struct Hit {
    double distance2_mm2 = std::numeric_limits<double>::infinity();
    std::uint32_t triangle = std::numeric_limits<std::uint32_t>::max();  ///< in the tree's order
  };

  explicit ClosestTriangle(const TriangleSoup& surface);

  /// The nearest triangle that is nearer than `bound`; `bound` itself if none is.
  [[nodiscard]] Hit nearest(const Vec3& mm, Hit bound) const noexcept;

  /// The squared distance to one triangle that nearest() gave.
  [[nodiscard]] double distance2_to(const Vec3& mm, std::uint32_t triangle) const noexcept;

 private:
  using Four = Eigen::Array4f;  ///< a number of each of four boxes, side by side

  /// A part of the triangles: a leaf of `count` from `first` on, or, count 0, the node `first`.
  struct Part {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  /// Four boxes, about origin_ and in single precision: wider than their triangles by more than
  /// what rounding can move. A box that is not there is infinitely far away.
  struct Node {
    std::array<Four, 9> axes;  ///< row by row: a box's directions; the last along the mean normal
    std::array<Four, 3> low, high;  ///< in the box's directions
    std::array<Part, 4> parts;
  };
  struct Triangle {
    Vec3 a, ab, ac;
  };

  struct Builder;

  Vec3 origin_ = Vec3::Zero();
  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;
};

}  // namespace beatlas::field
