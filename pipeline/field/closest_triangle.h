#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/field/surface.h"

namespace beatlas::field {

/// Distance from a point to the nearest of many triangles: a tree of flat cylinders that lie along
/// the surface, so that deep points, too, see only the few triangles about their foot. Four at a
/// time in single precision: exact but for rounding, 2e-7 of the way from the surface's middle
/// (0.00002 mm of a heart). Degenerate triangles count as the segments or points they are.
class ClosestTriangle {
 public:
  struct Hit {
    float distance2_mm2 = std::numeric_limits<float>::infinity();
    std::uint32_t four = std::numeric_limits<std::uint32_t>::max();  ///< triangles it is among
  };

  /// The parts of the surface about a place; many points there are found sooner from it.
  class Vicinity;

  explicit ClosestTriangle(const TriangleSoup& surface);

  /// The distance to the nearest triangle if that is less than `bound`, else `bound` itself.
  [[nodiscard]] Hit nearest(const Vec3& mm, Hit bound) const noexcept;
  /// The same for a point whose nearest triangle has a part of `about` in reach.
  [[nodiscard]] Hit nearest(const Vec3& mm, Hit bound, const Vicinity& about) const noexcept;
  /// The same among the four triangles that nearest() found for another point.
  [[nodiscard]] Hit nearest_of(std::uint32_t four, const Vec3& mm, Hit bound) const noexcept;

  /// Every part that comes nearer than `reach_mm` to `mm`, in parts of about `part_mm`.
  /// @param within a vicinity that holds them; null: the whole surface
  void gather(const Vec3& mm, double reach_mm, double part_mm, const Vicinity* within,
              Vicinity& out) const;

 private:
  using Four = Eigen::Array4f;  ///< a number of each of four, side by side
  using FourPoints = std::array<Four, 3>;

  /// Four parts of the surface, each within a flat cylinder along it, about origin_. A part that is
  /// not there is infinitely far away.
  struct Node {
    FourPoints centre, normal;
    Four half_height, radius;
    std::array<std::uint32_t, 4> part;  ///< a node, or with kIsPack four triangles
  };
  /// Four triangles about origin_; one that is not there is another once more.
  struct Pack {
    FourPoints a, ab, ac;
  };
  static constexpr std::uint32_t kIsPack = std::uint32_t{1} << 31;

  struct Builder;
  class Search;

  static Four distance2_to_parts(const Vec3f& at, const Node& node) noexcept;
  static Four distance2_to_pack(const Vec3f& at, const Pack& pack) noexcept;

  Vec3 origin_ = Vec3::Zero();
  std::vector<Node> nodes_;
  std::vector<Pack> packs_;
};

class ClosestTriangle::Vicinity {
 private:
  friend class ClosestTriangle;
  std::vector<Node> nodes_;
};

}  // namespace beatlas::field
