#pragma once
#include <vector>

#include "pipeline/field/interpolant.h"
#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {

using Cycle = std::vector<std::vector<Vec3>>;  ///< [phase][vertex], workspace [mm]

/// What lies off its surface, or is missed of it, weighs so much more than a thin triangle, which
/// is mended later.
constexpr double kLostWeighs = 10;

/// What of harmonic k of a cycle of `phases` is kept: 1 / (1 + (k / (0.42 phases))^8). Of 15 phases
/// 97 % of the fourth and 30 % of the seventh, which is hardly motion.
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

  /// Puts every vertex on its phases' surfaces. Where a slit or pocket of other phases is closed
  /// and left some farther off than half an edge, the mesh around is evened out, by area, until
  /// they are out of it: on the surface, or on a membrane across what is left of the slit.
  void leave_slits(Cycle& cycle) const;

  /// Puts every vertex on its phases' surfaces. Then, as long as a triangle is turned over or
  /// thinner than 20 degrees in some phase and it helps: one ring around it is evened out in every
  /// phase, and edges are flipped where that makes the worst triangle of all phases better.
  void settle(Cycle& cycle);

  /// Of all triangles of all phases the share that is turned over or thinner than 20 degrees, and
  /// ten times the share that lies more than 1 mm off its surface: thin triangles are mended later,
  /// but what is lost before a mesh is fitted stays lost. Of 24 meshes of real exams' hearts and
  /// right ventricles .0003 to .034 lay so far off, and .0004 to .035 of the fitted ones, nearly in
  /// the same order.
  [[nodiscard]] double flawed_share(const Cycle& cycle) const;

  /// What settle could not do on the surfaces is done off them, in the phase that needs it: two
  /// rings around triangles that pass through each other (CGAL), and one around those that are
  /// turned over or so thin that a package's rounding could bring them below 10 degrees, are
  /// smoothed; as long as that does not help, more of them and by area, so that large triangles
  /// draw apart what a shut pocket left in a lump. A slit that opens in some phases alone is
  /// bridged.
  /// @return crossings left, all phases
  int mend(Cycle& cycle);

  [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }

 private:
  /// What is wrong in a phase.
  struct Flaws {
    std::vector<bool> changed;  ///< triangles that moved since they were looked at
    std::vector<bool> thin;     ///< or turned over
    std::vector<std::pair<std::uint32_t, std::uint32_t>> crossings;
    std::size_t count = 0;
  };

  /// Flips edges of triangles that are thin in any phase; what was flipped is looked at again.
  void flip_thin(const Cycle& cycle, std::vector<Flaws>& flaws);
  void look_for_flaws(const std::vector<Vec3>& points, Flaws& flaws) const;
  void smooth_flaws(std::vector<Vec3>& points, int rings, bool stalled, Flaws& flaws) const;
  void find_neighbours();
  /// What moved vertices change: triangles that may be bad or good now, and what tells it.
  struct Patch {
    std::vector<std::uint32_t> triangles;  ///< ascending
    std::vector<std::uint32_t> around;     ///< all triangles at their corners, ascending
    std::vector<std::uint32_t> vertices;   ///< whose triangles are all among those
  };

  [[nodiscard]] Patch patch_around(const std::vector<bool>& moved) const;
  /// [vertex] as vertex_normals gives them, at vertices of the patch alone.
  [[nodiscard]] std::vector<Vec3> normals_in(const Patch& patch,
                                             const std::vector<Vec3>& points) const;
  /// Whether each triangle of the patch is turned over or thinner than 20 degrees.
  void look_for_bad(const std::vector<Vec3>& points, const Patch& patch,
                    std::vector<bool>& bad) const;
  /// Turned over, or so thin that a package's rounding could bring them below 10 degrees.
  [[nodiscard]] std::vector<bool> too_thin_triangles(const std::vector<Vec3>& points) const;
  [[nodiscard]] std::vector<bool> loosened(const std::vector<bool>& bad, int rings) const;
  /// The neighbours of vertices too, so many times.
  void grow(std::vector<bool>& vertices, int rings) const;
  void leave_slits(std::vector<Vec3>& points, std::size_t phase) const;
  /// [vertex] twice the area of the triangles at it.
  [[nodiscard]] std::vector<double> area_around(const std::vector<Vec3>& points) const;
  /// Of the ring, weighted by these areas.
  [[nodiscard]] Vec3 drawn_middle(const std::vector<Vec3>& points, const std::vector<double>& area,
                                  std::size_t v) const;
  [[nodiscard]] Vec3 middle_of_ring(const std::vector<Vec3>& points, std::size_t v) const;
  /// One step of evening out of loose vertices, along the surface. @param normals [vertex]
  void even_out(std::vector<Vec3>& points, const std::vector<bool>& loose,
                const std::vector<Vec3>& normals, std::size_t phase) const;
  void put_on_surface(std::vector<Vec3>& points, std::size_t phase) const;
  [[nodiscard]] Vec3 on_surface(const Vec3& mm, const Vec3& outward, std::size_t phase) const;
  /// @return how many edges were flipped
  int flip_edges(const Cycle& cycle, const std::vector<bool>& bad);
  /// Tells the neighbours that the edge from a to b runs from c to d now.
  void flip_in_rings(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);

  std::vector<Triangle> triangles_;
  std::vector<field::Interpolant> phases_;
  double edge_mm_;
  std::vector<std::vector<std::uint32_t>> ring_;  ///< [vertex] its neighbours, ascending
};

}  // namespace beatlas::mesh
