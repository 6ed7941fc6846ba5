// Remeshing with CGAL, in a file of its own: it takes a minute and gigabytes to compile.
#include <algorithm>
#include <cmath>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/Euler_operations.h>

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

/// Whether triangles around `v` keep their side, and do not become slivers, if it goes to `to`.
bool keeps_sides(const SurfaceMesh& mesh, SurfaceMesh::Halfedge_index v_to) {
  constexpr double kLeastAgreement = 0.7;  // of a triangle's normal with the ring's, cosine
  constexpr double kLeastShare = 0.05;  // of a triangle's doubled area in its longest edge's square
  const auto v = mesh.source(v_to);
  const Point& to = mesh.point(mesh.target(v_to));
  Kernel::Vector_3 ring(0, 0, 0);
  for (const auto h : CGAL::halfedges_around_source(v, mesh)) {
    const Point& a = mesh.point(mesh.target(h));
    const Point& b = mesh.point(mesh.target(mesh.next(h)));
    ring = ring + CGAL::cross_product(a - mesh.point(v), b - mesh.point(v));
  }
  const double length = std::sqrt(ring.squared_length());
  for (const auto h : CGAL::halfedges_around_source(v, mesh)) {
    if (h == v_to || mesh.next(mesh.next(h)) == mesh.opposite(v_to)) continue;
    const Point& a = mesh.point(mesh.target(h));
    const Point& b = mesh.point(mesh.target(mesh.next(h)));
    const Kernel::Vector_3 normal = CGAL::cross_product(a - to, b - to);
    const double area = std::sqrt(normal.squared_length());
    const double longest = std::max({CGAL::squared_distance(a, to), CGAL::squared_distance(b, to),
                                     CGAL::squared_distance(a, b)});
    if (!(normal * ring > kLeastAgreement * area * length) || area < kLeastShare * longest) {
      return false;
    }
  }
  return true;
}

/// Collapses edges shorter than that onto one of their ends. The remesher would do the same with
/// a queue of all edges, which of a surface made of very many small triangles takes most of its
/// time.
void collapse_short_edges(SurfaceMesh& mesh, double shorter_mm) {
  const auto edges = static_cast<std::uint32_t>(mesh.num_edges());
  for (std::uint32_t n = 0; n < edges; ++n) {
    const SurfaceMesh::Edge_index edge(n);
    if (mesh.is_removed(edge)) continue;
    for (const auto v_to : {mesh.halfedge(edge, 0), mesh.halfedge(edge, 1)}) {
      const Point from = mesh.point(mesh.source(v_to));
      const Point to = mesh.point(mesh.target(v_to));
      if (CGAL::squared_distance(from, to) >= shorter_mm * shorter_mm) break;
      if (!keeps_sides(mesh, v_to) || !CGAL::Euler::does_satisfy_link_condition(edge, mesh))
        continue;
      mesh.point(CGAL::Euler::collapse_edge(edge, mesh)) = to;
      break;
    }
  }
}

}  // namespace

TriangleMesh remeshed(const TriangleMesh& mesh, double edge_mm) {
  constexpr unsigned kRounds = 5;
  constexpr unsigned kRelaxations = 2;
  constexpr double kShort = 0.5;  // of an edge: what the remesher would collapse in any case
  SurfaceMesh work = to_cgal(mesh.points, mesh.triangles);
  collapse_short_edges(work, kShort * edge_mm);
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
