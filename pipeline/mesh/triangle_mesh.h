#pragma once
/// What the files of this room pass to one another; no library's type in sight.

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pipeline/field/interpolant.h"
#include "runtime/base/geometry.h"

namespace beatlas::mesh {

using Triangle = std::array<std::uint32_t, 3>;

/// Triangles counter-clockwise seen from outside; workspace [mm].
struct TriangleMesh {
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
};

/// Volume [ml] a closed mesh encloses.
[[nodiscard]] double enclosed_ml(std::span<const Vec3> points, std::span<const Triangle> triangles);

/// Unit normals, area-weighted; zero where the triangles around cancel out.
[[nodiscard]] std::vector<Vec3> vertex_normals(std::span<const Vec3> points,
                                               std::span<const Triangle> triangles);

/// Which triangles face against the mean normal at their vertices.
[[nodiscard]] std::vector<bool> flipped_triangles(std::span<const Vec3> points,
                                                  std::span<const Triangle> triangles);

/// The smallest of a triangle's angles, 0 for a degenerate one.
[[nodiscard]] double least_angle_deg(const Vec3& a, const Vec3& b, const Vec3& c);

/// How far a mesh lies off a surface: |distance| and distance [mm] times area [mm2], summed over
/// four points of each triangle. Of a part of the surface that no triangle reaches this knows what
/// cuts it off; vertices, which lie on the surface wherever they are, know nothing of it.
struct OffSurface {
  double area = 0;
  double off = 0;
  double signed_off = 0;

  [[nodiscard]] double mean_mm() const { return area > 0 ? off / area : 0; }
};
[[nodiscard]] OffSurface off_surface(std::span<const Vec3> points,
                                     std::span<const Triangle> triangles,
                                     const field::Interpolant& surface);

/// Closed manifold: every edge has two faces that run through it in opposite directions, and the
/// faces at every vertex form one ring. No vertex is without faces.
struct Topology {
  bool closed_manifold = false;
  int euler_number = 0;
};
[[nodiscard]] Topology inspect(std::size_t vertex_count, std::span<const Triangle> triangles);

// topology.cpp (OpenMesh)

/// The component that encloses the most, and how many there were.
/// @pre `mesh` is a closed manifold.
struct LargestComponent {
  TriangleMesh mesh;
  int components = 0;
  double others_ml = 0;  ///< |volume| of what was left out
};
[[nodiscard]] LargestComponent largest_component(const TriangleMesh& mesh);

/// The vertices next to each vertex with weights (cot a + cot b) / 2 of the mesh's own shape, not
/// below a twentieth so that the Laplacian stays positive. Neighbours of v are
/// at[first[v]..first[v + 1]).
struct Neighbours {
  std::vector<std::uint32_t> first;
  std::vector<std::uint32_t> at;
  std::vector<double> weight;
};
[[nodiscard]] Neighbours cotangent_neighbours(const TriangleMesh& mesh);

/// Evens out triangles: moves each vertex along the surface to the area-weighted middle of its
/// ring (Botsch and Kobbelt 2004) and back to the zero of `surface`, `rounds` times.
void relax_on_surface(TriangleMesh& mesh, const field::Interpolant& surface, int rounds);

// remesh_cgal.cpp (CGAL)

/// Isotropic remeshing (Botsch and Kobbelt 2004) to edges of about edge_mm.
/// @pre `mesh` is a closed manifold.
[[nodiscard]] TriangleMesh remeshed(const TriangleMesh& mesh, double edge_mm);

/// A place on a mesh: the corners' weights add up to 1.
struct OnTriangle {
  std::uint32_t triangle = 0;
  std::array<double, 3> weight{};
};
/// The place of `mesh` nearest to each point.
[[nodiscard]] std::vector<OnTriangle> located(const TriangleMesh& mesh,
                                              std::span<const Vec3> points);

// self_crossings.cpp (CGAL)

/// Pairs of triangles, ascending, that meet other than in a shared vertex or edge (exact
/// predicates).
/// @param among only pairs of which one is of these; empty: all
[[nodiscard]] std::vector<std::pair<std::uint32_t, std::uint32_t>> self_intersections(
    std::span<const Vec3> points, std::span<const Triangle> triangles,
    const std::vector<bool>& among = {});

/// Triangles of one mesh and of another that meet, each pair once.
[[nodiscard]] std::vector<std::pair<Triangle, Triangle>> crossings(
    std::span<const Vec3> points, std::span<const Triangle> triangles,
    std::span<const Vec3> other_points, std::span<const Triangle> other_triangles);

}  // namespace beatlas::mesh
