#include <algorithm>
#include <cmath>
#include <numbers>

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

/// See MeshQuality; sums of squares.
void measure_jitter(const SurfaceCycle& surface, MeshQuality& out) {
  const std::size_t phases = surface.positions.size();
  // What is left of a way without its mean and its harmonics up to a third of the phases.
  std::vector<double> weight(phases);
  for (std::size_t d = 0; d < phases; ++d) {
    for (std::size_t k = 0; k < phases; ++k) {
      if (3 * std::min(k, phases - k) <= phases) continue;
      weight[d] += std::cos(2 * std::numbers::pi * static_cast<double>(k * d % phases) /
                            static_cast<double>(phases)) /
                   static_cast<double>(phases);
    }
  }
  std::vector<double> along(phases);
  std::vector<double> across(phases);
  parallel_for(phases, [&](std::size_t p) {
    std::vector<Vec3> points;
    for (const Vec3f& x : surface.positions[p]) points.emplace_back(x.cast<double>());
    const std::vector<Vec3> normals = vertex_normals(points, surface.triangles);
    for (std::size_t v = 0; v < points.size(); ++v) {
      Vec3 quick = Vec3::Zero();
      for (std::size_t q = 0; q < phases; ++q) {
        quick += weight[(p + phases - q) % phases] * surface.positions[q][v].cast<double>();
      }
      const double normal = normals[v].dot(quick);
      across[p] += normal * normal;
      along[p] += (quick - normal * normals[v]).squaredNorm();
    }
  });
  double along_sum = 0;
  double across_sum = 0;
  for (std::size_t p = 0; p < phases; ++p) {
    along_sum += along[p];
    across_sum += across[p];
  }
  const auto count = static_cast<double>(phases * surface.positions.front().size());
  out.tangential_jitter_mm = std::sqrt(along_sum / count);
  out.normal_jitter_mm = std::sqrt(across_sum / count);
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
  measure_jitter(surface, out);
  return out;
}

}  // namespace beatlas::mesh
