#include <algorithm>

#include "pipeline/core/parallel.h"
#include "pipeline/mesh/mesh.h"
#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {
namespace {

PhaseQuality measure_phase(const std::vector<Vec3f>& positions,
                           const std::vector<Triangle>& triangles) {
  std::vector<Vec3> points;
  points.reserve(positions.size());
  for (const Vec3f& p : positions) points.emplace_back(p.cast<double>());

  PhaseQuality out;
  std::vector<double> angles;
  angles.reserve(triangles.size());
  double edges_mm = 0;
  for (const Triangle& t : triangles) {
    const std::array<Vec3, 3> corner{points[t[0]], points[t[1]], points[t[2]]};
    angles.push_back(least_angle_deg(corner[0], corner[1], corner[2]));
    for (std::size_t n = 0; n < 3; ++n) edges_mm += (corner[(n + 1) % 3] - corner[n]).norm();
  }
  const std::vector<bool> flipped = flipped_triangles(points, triangles);
  out.flipped_triangles = static_cast<int>(std::count(flipped.begin(), flipped.end(), true));
  if (!triangles.empty()) {
    std::sort(angles.begin(), angles.end());
    out.least_angle_deg = angles.front();
    out.percentile_1_angle_deg = angles[angles.size() / 100];
    out.mean_edge_mm = edges_mm / static_cast<double>(3 * triangles.size());
  }
  out.self_intersections = static_cast<int>(self_intersections(points, triangles).size());
  out.volume_ml = enclosed_ml(points, triangles);
  return out;
}

}  // namespace

MeshQuality measure_quality(const SurfaceCycle& surface) {
  MeshQuality out;
  const std::size_t vertices = surface.positions.empty() ? 0 : surface.positions.front().size();
  const Topology topology = inspect(vertices, surface.triangles);
  out.closed_manifold = topology.closed_manifold;
  out.euler_number = topology.euler_number;
  out.phases.resize(surface.positions.size());
  // Self-intersection needs a mesh to walk on.
  if (!out.closed_manifold) return out;
  parallel_for(out.phases.size(), [&](std::size_t p) {
    out.phases[p] = measure_phase(surface.positions[p], surface.triangles);
  });
  return out;
}

}  // namespace beatlas::mesh
