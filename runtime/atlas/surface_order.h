#pragma once
/// In which order a surface's vertices are coded and how each is told from those before it. Encoder
/// and decoder make the same from what both know: the triangles and the cycle's mean surface.

#include <array>
#include <span>
#include <vector>

#include "runtime/base/geometry.h"

namespace beatlas::atlas {

/// Coarse vertices first, so that nearly every vertex has known ones on all sides.
///
/// The graph of edges is thinned: of the vertices with at most kMostKnown neighbours no two
/// adjacent ones are taken out at once, lowest number first; a vertex's neighbours are its *known*
/// ones, and the one of them with the fewest edges (the lowest number among equals) is joined to
/// the others, so that the hole stays closed. Rounds end when they take out less than an eighth;
/// what is left then is ordered by number, known ones being neighbours of lower number. Coded is in
/// the opposite direction. Time and memory are linear in the triangles, whatever they are.
class SurfaceOrder {
 public:
  static constexpr std::size_t kMostKnown = 8;

  /// @param mean_mm positions by vertex, finite; every triangle's vertices are among them
  SurfaceOrder(const std::vector<std::array<std::uint32_t, 3>>& triangles,
               const std::vector<Vec3f>& mean_mm);

  /// Every vertex once, in coding order.
  [[nodiscard]] const std::vector<std::uint32_t>& vertices() const noexcept { return vertices_; }

  /// Vertices that come before `vertex` and tell of it; none for the first.
  [[nodiscard]] std::span<const std::uint32_t> known(std::uint32_t vertex) const noexcept {
    return {known_.data() + first_[vertex], known_.data() + first_[vertex + 1]};
  }

  /// Their weights, of sum 1: those with which an affine function of place, fitted to the known
  /// ones (nearer ones count more), is read off at the vertex, so that a smooth motion is foretold
  /// to second order on an uneven mesh. Equal ones where the fit is not steady.
  [[nodiscard]] std::vector<double> weights(std::uint32_t vertex) const;

  /// Rows: normal of the mean surface at the vertex, and two tangents. Noise of a surface that was
  /// found in images lies along the normal, so that the other two rows take few bits.
  [[nodiscard]] Eigen::Matrix3d frame(std::uint32_t vertex) const;

 private:
  const std::vector<Vec3f>& mean_mm_;
  std::vector<Vec3> normals_;
  std::vector<std::uint32_t> vertices_;
  std::vector<std::uint32_t> first_;  ///< [vertex] where its known ones begin, and the end
  std::vector<std::uint32_t> known_;
};

}  // namespace beatlas::atlas
