#include "pipeline/assess/drawn_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "pipeline/assess/statistics.h"
#include "pipeline/assess/surface_checks.h"
#include "pipeline/core/parallel.h"
#include "runtime/base/triangle.h"

namespace beatlas::assess {
namespace {

struct Triangle {
  std::array<Vec3, 3> corners;
  Vec3 middle = Vec3::Zero();
  double reach = 0;  ///< [mm] from the middle to the farthest corner

  [[nodiscard]] Vec3 area_normal() const {
    return 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  }
};

/// In workspace [mm].
std::vector<Triangle> triangles_of(const atlas::SurfacePayload& surface, std::size_t phase) {
  const std::vector<Vec3f>& positions = surface.positions[phase];
  std::vector<Triangle> out;
  out.reserve(surface.triangles.size());
  for (const auto& corners : surface.triangles) {
    Triangle triangle;
    for (std::size_t c = 0; c < 3; ++c) triangle.corners[c] = positions[corners[c]].cast<double>();
    triangle.middle = (triangle.corners[0] + triangle.corners[1] + triangle.corners[2]) / 3;
    for (const Vec3& corner : triangle.corners) {
      triangle.reach = std::max(triangle.reach, (corner - triangle.middle).norm());
    }
    out.push_back(triangle);
  }
  return out;
}

/// [mm] + outside; none where there is no triangle.
std::optional<double> signed_distance(const std::vector<Triangle>& triangles, const Vec3& x) {
  double least = std::numeric_limits<double>::infinity();
  double side = 1;
  for (const Triangle& triangle : triangles) {
    const double least_possible = (triangle.middle - x).norm() - triangle.reach;
    if (least_possible >= least) continue;
    const auto& [a, b, c] = triangle.corners;
    const Vec3 weights = nearest_of_triangle(x, a, b, c);
    const Vec3 off = x - weights[0] * a - weights[1] * b - weights[2] * c;
    if (off.norm() >= least) continue;
    least = off.norm();
    side = off.dot(triangle.area_normal());
  }
  if (triangles.empty()) return {};
  return std::copysign(least, side);
}

}  // namespace

DrawnErrors drawn_errors(const atlas::SurfacePayload& surface, const Affine& workspace_from_lps,
                         const phantom::Phantom& truth, int p, const CompareOptions& options) {
  DrawnErrors out;
  const auto phase = static_cast<std::size_t>(p);
  const double share = p / static_cast<double>(surface.positions.size());
  const auto frame = truth.frame(share * truth.spec().rr_interval_s);
  if (!frame->has(surface.structure)) return out;
  const std::vector<Triangle> triangles = triangles_of(surface, phase);
  std::vector<double> area(surface.positions[phase].size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const double third = triangles[t].area_normal().norm() / 3;
    for (const std::uint32_t corner : surface.triangles[t]) area[corner] += third;
  }
  const Affine lps_from_workspace = workspace_from_lps.inverse();
  const auto on_crease = [&](const Vec3& lps) {
    return frame->crease_distance_mm(surface.structure, lps) < options.crease_band_mm;
  };
  std::vector<Weighted> to_truth;
  for (std::size_t v = 0; v < area.size(); ++v) {
    const Vec3 lps = lps_from_workspace * surface.positions[phase][v].cast<double>();
    const phantom::Nearest nearest = frame->nearest(surface.structure, lps);
    if (!on_crease(nearest.point)) to_truth.push_back({nearest.distance_mm, area[v]});
  }
  const std::vector<Vec3> samples =
      frame->sample_surface(surface.structure, options.sample_spacing_mm);
  std::vector<std::optional<double>> distances(samples.size());
  parallel_for(samples.size(), [&](std::size_t n) {
    if (on_crease(samples[n])) return;
    distances[n] = signed_distance(triangles, workspace_from_lps * samples[n]);
  });
  std::vector<Weighted> to_package;
  for (const std::optional<double>& distance : distances) {
    if (distance) to_package.push_back({-*distance});
  }
  set_distances(pooled_statistics(to_truth, to_package), out);
  const double true_ml = frame->volume_ml(surface.structure);
  out.volume_error_ml = enclosed_volume_ml(surface.triangles, surface.positions[phase]) - true_ml;
  out.volume_error_percent = 100 * out.volume_error_ml / true_ml;
  out.points = static_cast<int>(to_truth.size() + to_package.size());
  return out;
}

}  // namespace beatlas::assess
