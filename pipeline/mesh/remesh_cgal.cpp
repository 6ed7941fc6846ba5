// Remeshing with CGAL, in a file of its own: it takes a minute and gigabytes to compile.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh.h>

#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;

SurfaceMesh to_cgal(std::span<const Vec3> points, std::span<const Triangle> triangles) {
  std::vector<Point> positions;
  positions.reserve(points.size());
  for (const Vec3& p : points) positions.emplace_back(p.x(), p.y(), p.z());
  std::vector<std::array<std::size_t, 3>> faces;
  faces.reserve(triangles.size());
  for (const Triangle& t : triangles) faces.push_back({t[0], t[1], t[2]});
  SurfaceMesh out;
  pmp::polygon_soup_to_polygon_mesh(positions, faces, out);
  return out;
}

TriangleMesh from_cgal(SurfaceMesh& mesh) {
  mesh.collect_garbage();
  TriangleMesh out;
  out.points.reserve(mesh.number_of_vertices());
  for (const auto v : mesh.vertices()) {
    const Point& p = mesh.point(v);
    out.points.emplace_back(p.x(), p.y(), p.z());
  }
  out.triangles.reserve(mesh.number_of_faces());
  for (const auto f : mesh.faces()) {
    Triangle t{};
    std::size_t n = 0;
    for (const auto v : CGAL::vertices_around_face(mesh.halfedge(f), mesh)) {
      t[n++] = static_cast<std::uint32_t>(v);
    }
    out.triangles.push_back(t);
  }
  return out;
}

}  // namespace

TriangleMesh remeshed(const TriangleMesh& mesh, double edge_mm) {
  constexpr unsigned kRounds = 5;
  constexpr unsigned kRelaxations = 2;
  SurfaceMesh work = to_cgal(mesh.points, mesh.triangles);
  pmp::isotropic_remeshing(
      work.faces(), edge_mm, work,
      CGAL::parameters::number_of_iterations(kRounds).number_of_relaxation_steps(kRelaxations));
  return from_cgal(work);
}

std::vector<OnTriangle> located(const TriangleMesh& mesh, std::span<const Vec3> points) {
  std::vector<Kernel::Triangle_3> faces;
  faces.reserve(mesh.triangles.size());
  const auto point = [](const Vec3& p) { return Point(p.x(), p.y(), p.z()); };
  for (const Triangle& t : mesh.triangles) {
    faces.emplace_back(point(mesh.points[t[0]]), point(mesh.points[t[1]]),
                       point(mesh.points[t[2]]));
  }
  using Primitive =
      CGAL::AABB_triangle_primitive<Kernel, std::vector<Kernel::Triangle_3>::iterator>;
  CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree(faces.begin(), faces.end());
  std::vector<OnTriangle> out;
  out.reserve(points.size());
  for (const Vec3& p : points) {
    const auto [foot, face] = tree.closest_point_and_primitive(point(p));
    const auto n = static_cast<std::size_t>(face - faces.begin());
    const Triangle& t = mesh.triangles[n];
    const Vec3 at(foot.x(), foot.y(), foot.z());
    const Vec3 normal =
        (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]);
    OnTriangle& place = out.emplace_back();
    place.triangle = static_cast<std::uint32_t>(n);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& b = mesh.points[t[(k + 1) % 3]];
      const Vec3& c = mesh.points[t[(k + 2) % 3]];
      place.weight[k] = (b - at).cross(c - at).dot(normal) / normal.squaredNorm();
    }
  }
  return out;
}

}  // namespace beatlas::mesh
