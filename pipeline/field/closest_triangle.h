#pragma once
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
  struct Node {
    Eigen::Matrix3d axes;     ///< rows: the box's directions; the last along the mean normal
    Vec3 low, high;           ///< in the box's directions
    std::uint32_t first = 0;  ///< a leaf's first triangle, or an inner node's right child
    std::uint32_t count = 0;  ///< triangles of a leaf; 0 for an inner node, its left child is next
  };
  struct Triangle {
    Vec3 a, ab, ac;
  };

  std::uint32_t build(std::vector<std::uint32_t>& order, const TriangleSoup& surface,
                      const std::vector<Vec3>& centres, std::uint32_t first, std::uint32_t last);

  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;
};

}  // namespace beatlas::field
