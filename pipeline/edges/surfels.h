#pragma once
/// A body's surface in space as small pieces of it.

#include <array>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::edges {

/// A piece of a surface: where it lies, which way it looks and how it bends. In millimetres along
/// the grid's axes from the middle of its first voxel.
struct Surfel {
  Vec3 at = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< outward, unit
  Vec3 along = Vec3::UnitX();   ///< unit, tangent
  Vec3 across = Vec3::UnitY();  ///< unit, tangent, normal to `along`
  /// How far it rises along the normal at (u, v) along and across: bend . (u^2, u v, v^2) [1/mm].
  std::array<double, 3> bend{};

  /// How far outside of the surface a place lies that is `off` from `at` [mm].
  [[nodiscard]] double outside_mm(const Vec3& off) const {
    const double u = off.dot(along);
    const double v = off.dot(across);
    return off.dot(normal) - (bend[0] * u * u + bend[1] * u * v + bend[2] * v * v);
  }
};

/// Pieces of the 0.5 level of a coverage, about `pitch_mm` apart: of the coverage smoothed by a
/// Gaussian of 2 mm, and of quadrics that fit its crossings of the grid's lines within 6 mm.
/// @param coverage 0..1 of each voxel; labels as 0 and 1 will do
/// @param pitch_mm 1..10
[[nodiscard]] std::vector<Surfel> surfels_of(const Grid& grid, const std::vector<float>& coverage,
                                             double pitch_mm);

/// Places in cells, to find those near another.
class PlacesNearby {
 public:
  /// @param reach_mm > 0: the cells' width
  PlacesNearby(std::vector<Vec3> places, double reach_mm);

  /// Calls `visit(n, off)` for each place within reach, in the same order each time.
  template <class Visit>
  void visit(const Vec3& from, const Visit& visit) const {
    const Index3 cell = cell_of(from);
    for (int k = std::max(0, cell[2] - 1); k <= std::min(size_[2] - 1, cell[2] + 1); ++k) {
      for (int j = std::max(0, cell[1] - 1); j <= std::min(size_[1] - 1, cell[1] + 1); ++j) {
        for (int i = std::max(0, cell[0] - 1); i <= std::min(size_[0] - 1, cell[0] + 1); ++i) {
          const std::size_t at = index(i, j, k);
          for (std::size_t n = first_[at]; n < first_[at + 1]; ++n) {
            const Vec3 off = places_[order_[n]] - from;
            if (off.squaredNorm() <= reach_mm_ * reach_mm_) visit(order_[n], off);
          }
        }
      }
    }
  }

 private:
  [[nodiscard]] Index3 cell_of(const Vec3& place) const;
  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(size_[0]) *
               (static_cast<std::size_t>(j) +
                static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(k));
  }

  std::vector<Vec3> places_;
  double reach_mm_;
  Vec3 low_ = Vec3::Zero();
  Index3 size_{0, 0, 0};
  std::vector<std::size_t> first_;  ///< [cell] in order_
  std::vector<std::size_t> order_;
};

}  // namespace beatlas::edges
