#pragma once
#include <vector>

#include "pipeline/field/interpolant.h"
#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {

using Cycle = std::vector<std::vector<Vec3>>;  ///< [phase][vertex], workspace [mm]

/// What of harmonic k of a cycle of `phases` is kept: 1 / (1 + (k / (0.42 phases))^8). Of 15 phases
/// 97 % of the fourth and 26 % of the seventh, which is nearly all noise: the phantom's own motion
/// has 3 % of its amplitude beyond the fifth.
[[nodiscard]] double kept_of_harmonic(int k, int phases);

/// Fits one connectivity to the zero surfaces of all phases at once, so that what is done to a
/// vertex for the sake of one phase is done in all and no phase jumps.
class CycleFit {
 public:
  /// @param phases of the cycle, one surface each; @param edge_mm of the triangles
  CycleFit(std::vector<Triangle> triangles, std::vector<field::Interpolant> phases, double edge_mm);

  /// Takes the quickest changes along the surface off every vertex's way around the cycle (see
  /// kept_of_harmonic); the way along the normal stays the surface's own. Cycles of fewer than 8
  /// phases stay as they are.
  void calm(Cycle& cycle) const;

  /// Puts every vertex on its phases' surfaces. Then, as long as a triangle is turned over or
  /// thinner than 16 degrees in some phase and it helps: one ring around it is evened out in every
  /// phase, and edges are flipped where that makes the worst triangle of all phases better.
  void settle(Cycle& cycle);

  /// Draws sheets that pass through each other apart: vertices of crossing triangles (CGAL) and two
  /// rings around them are smoothed off the surface, in their phase alone. @return crossings left
  int part(Cycle& cycle) const;

  [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }

 private:
  void find_neighbours();
  [[nodiscard]] std::vector<bool> bad_triangles(const std::vector<Vec3>& points) const;
  [[nodiscard]] std::vector<bool> loosened(const std::vector<bool>& bad, int rings) const;
  [[nodiscard]] Vec3 middle_of_ring(const std::vector<Vec3>& points, std::size_t v) const;
  [[nodiscard]] Vec3 on_surface(const Vec3& mm, const Vec3& outward, std::size_t phase) const;
  void flip_edges(const Cycle& cycle, const std::vector<bool>& bad);

  std::vector<Triangle> triangles_;
  std::vector<field::Interpolant> phases_;
  double edge_mm_;
  std::vector<std::vector<std::uint32_t>> ring_;  ///< [vertex] its neighbours, ascending
};

}  // namespace beatlas::mesh
