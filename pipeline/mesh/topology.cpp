#include <algorithm>
#include <cmath>
#include <numeric>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {
namespace {

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using OmMesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;

// @pre closed manifold; OpenMesh would print its complaints otherwise.
void fill(OmMesh& out, std::size_t vertex_count, std::span<const Triangle> triangles) {
  out.reserve(vertex_count, 3 * triangles.size() / 2, triangles.size());
  for (std::size_t v = 0; v < vertex_count; ++v) out.add_vertex(OmMesh::Point(0.0));
  const auto vertex = [](std::uint32_t v) { return OmMesh::VertexHandle(static_cast<int>(v)); };
  for (const Triangle& t : triangles) out.add_face(vertex(t[0]), vertex(t[1]), vertex(t[2]));
}

std::size_t index(OmMesh::VertexHandle v) { return static_cast<std::size_t>(v.idx()); }

Vec3 doubled_area(const std::vector<Vec3>& points, const Triangle& t) {
  return (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
}

double cotangent(const Vec3& corner, const Vec3& a, const Vec3& b) {
  const Vec3 u = a - corner;
  const Vec3 v = b - corner;
  const double area = u.cross(v).norm();
  return area > 0 ? u.dot(v) / area : 0.0;
}

}  // namespace

LargestComponent largest_component(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.points.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t n = 1; n < 3; ++n) {
      const std::uint32_t a = root(t[0]);
      const std::uint32_t b = root(t[n]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<double> volume(mesh.points.size(), 0.0);
  std::vector<bool> used(mesh.points.size(), false);
  const Vec3 pivot = mesh.points.empty() ? Vec3::Zero() : mesh.points.front();
  for (const Triangle& t : mesh.triangles) {
    used[root(t[0])] = true;
    volume[root(t[0])] += (mesh.points[t[0]] - pivot)
                              .dot((mesh.points[t[1]] - pivot).cross(mesh.points[t[2]] - pivot)) /
                          6000.0;
  }
  LargestComponent out;
  std::uint32_t best = 0;
  double best_ml = -1;
  for (std::uint32_t v = 0; v < parent.size(); ++v) {
    if (!used[v]) continue;
    ++out.components;
    out.others_ml += std::abs(volume[v]);
    if (volume[v] > best_ml) {
      best = v;
      best_ml = volume[v];
    }
  }
  out.others_ml -= std::max(best_ml, 0.0);
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> renumbered(mesh.points.size(), kNone);
  for (const Triangle& t : mesh.triangles) {
    if (root(t[0]) != best) continue;
    Triangle kept{};
    for (std::size_t n = 0; n < 3; ++n) {
      std::uint32_t& number = renumbered[t[n]];
      if (number == kNone) {
        number = static_cast<std::uint32_t>(out.mesh.points.size());
        out.mesh.points.push_back(mesh.points[t[n]]);
      }
      kept[n] = number;
    }
    out.mesh.triangles.push_back(kept);
  }
  return out;
}

Neighbours cotangent_neighbours(const TriangleMesh& mesh) {
  OmMesh half_edges;
  fill(half_edges, mesh.points.size(), mesh.triangles);
  Neighbours out;
  out.first.push_back(0);
  constexpr double kLeast = 0.05;
  for (const auto v : half_edges.vertices()) {
    for (const auto edge : half_edges.voh_range(v)) {
      const Vec3& from = mesh.points[index(v)];
      const Vec3& to = mesh.points[index(half_edges.to_vertex_handle(edge))];
      double sum = 0;
      for (const auto side : {edge, half_edges.opposite_halfedge_handle(edge)}) {
        const auto across = half_edges.to_vertex_handle(half_edges.next_halfedge_handle(side));
        sum += cotangent(mesh.points[index(across)], from, to);
      }
      out.at.push_back(static_cast<std::uint32_t>(half_edges.to_vertex_handle(edge).idx()));
      out.weight.push_back(std::max(0.5 * sum, kLeast));
    }
    out.first.push_back(static_cast<std::uint32_t>(out.at.size()));
  }
  return out;
}

void relax_on_surface(TriangleMesh& mesh, const field::Interpolant& surface, int rounds) {
  OmMesh half_edges;
  fill(half_edges, mesh.points.size(), mesh.triangles);
  constexpr double kMaxStepMm = 1.0;
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> area(mesh.points.size(), 0.0);
    std::vector<Vec3> normal(mesh.points.size(), Vec3::Zero());
    for (const Triangle& t : mesh.triangles) {
      const Vec3 n = doubled_area(mesh.points, t);
      for (std::uint32_t v : t) {
        area[v] += n.norm();
        normal[v] += n;
      }
    }
    std::vector<Vec3> moved(mesh.points.size());
    for (const auto v : half_edges.vertices()) {
      const Vec3& here = mesh.points[index(v)];
      Vec3 middle = Vec3::Zero();
      double weight = 0;
      for (const auto neighbour : half_edges.vv_range(v)) {
        middle += area[index(neighbour)] * mesh.points[index(neighbour)];
        weight += area[index(neighbour)];
      }
      const Vec3 n = normal[index(v)].normalized();
      const Vec3 way = weight > 0 ? Vec3(middle / weight - here) : Vec3::Zero();
      moved[index(v)] = surface.project_to_zero(here + way - n.dot(way) * n, kMaxStepMm);
    }
    mesh.points = std::move(moved);
  }
}

}  // namespace beatlas::mesh
