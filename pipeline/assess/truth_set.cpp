#include "pipeline/assess/truth_set.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "pipeline/assess/statistics.h"
#include "pipeline/core/parallel.h"

namespace beatlas::assess {
namespace {

constexpr int kMomentsAFrame = 3;

std::vector<TruthPoint> surface_points(const phantom::Phantom& phantom, Structure structure,
                                       const TruthOptions& options) {
  const int moments = kMomentsAFrame * phantom.spec().phases;
  std::vector<TruthPoint> out;
  for (int m = 0; m < moments; ++m) {
    const double share = static_cast<double>(m) / moments;
    const auto frame = phantom.frame(share * phantom.spec().rr_interval_s);
    const std::vector<Vec3> samples = frame->sample_surface(structure, options.spacing_mm);
    std::vector<TruthPoint> found(samples.size());
    parallel_for(samples.size(), [&](std::size_t n) {
      if (frame->crease_distance_mm(structure, samples[n]) < options.crease_band_mm) return;
      const phantom::Nearest nearest = frame->nearest(structure, samples[n]);
      found[n] = {nearest.point, nearest.outward, share};
      found[n].share = share + 1;  // marks it as kept
    });
    for (TruthPoint& point : found) {
      if (point.share < 1) continue;
      point.share = share;
      point.in_frame = m % kMomentsAFrame == 0;
      out.push_back(point);
    }
  }
  return out;
}

/// @param frames those of the distances that are at times of frames
SurfaceErrors summed(const std::vector<Weighted>& distances, const std::vector<Weighted>& angles,
                     const std::vector<Weighted>& frames) {
  const DistanceStatistics distance = pooled_statistics(distances, {});
  return {distance.mean,
          distance.p95,
          pooled_statistics(frames, {}).mean,
          distance.bias,
          pooled_statistics(angles, {}).p95,
          static_cast<int>(distances.size())};
}

/// What one triangle of a stored surface is off at its corners and its middle.
struct TriangleErrors {
  std::array<double, 4> distance{};
  int count = 0;      ///< of distances; places near a crease have none
  double angle = -1;  ///< [deg] between normals at the middle; -1 near a crease
};

TriangleErrors triangle_errors(const std::array<Vec3, 3>& corner, const phantom::Frame& frame,
                               Structure structure, double crease_band_mm) {
  TriangleErrors out;
  const Vec3 middle = (corner[0] + corner[1] + corner[2]) / 3;
  for (std::size_t c = 0; c < 4; ++c) {
    const phantom::Nearest nearest = frame.nearest(structure, c < 3 ? corner[c] : middle);
    if (frame.crease_distance_mm(structure, nearest.point) < crease_band_mm) continue;
    out.distance[static_cast<std::size_t>(out.count++)] = nearest.distance_mm;
    if (c < 3) continue;
    const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    out.angle = angle_deg(normal, nearest.outward);
  }
  return out;
}

}  // namespace

TruthSet make_truth_set(const phantom::Phantom& phantom, const std::vector<Structure>& structures,
                        const TruthOptions& options, StageContext& context) {
  TruthSet out;
  for (const Structure structure : structures) {
    context.check_cancelled();
    out.surfaces[structure] = surface_points(phantom, structure, options);
    context.progress(static_cast<double>(out.surfaces.size()) /
                     static_cast<double>(structures.size() + 1));
  }
  PalpationOptions palpations;
  palpations.places = options.palpated_places;
  palpations.cycles = 1;
  out.forces =
      true_forces(phantom, palpation_set(phantom, palpations), options.stiffness_n_per_m, context);
  return out;
}

SurfaceErrors surface_errors(const MakeTouch& candidate, const std::vector<TruthPoint>& points,
                             const Affine& workspace_from_lps, double rr_interval_s) {
  const ForceAt touch = candidate();
  std::vector<Weighted> distances;
  std::vector<Weighted> angles;
  std::vector<Weighted> frames;
  for (const TruthPoint& point : points) {
    const haptics::Contact at = touch(workspace_from_lps * point.lps, point.share * rr_interval_s);
    distances.push_back({-at.distance_mm});
    if (point.in_frame) frames.push_back({-at.distance_mm});
    angles.push_back({angle_deg(at.normal, workspace_from_lps.linear() * point.normal)});
  }
  return summed(distances, angles, frames);
}

SurfaceErrors mesh_errors(const std::vector<std::array<std::uint32_t, 3>>& triangles,
                          const std::vector<std::vector<Vec3f>>& positions, Structure structure,
                          const phantom::Phantom& phantom, const Affine& workspace_from_lps,
                          double crease_band_mm) {
  constexpr std::size_t kMost = 1000;  // triangles a phase, four points each
  const Affine lps_from_workspace = workspace_from_lps.inverse(Eigen::Isometry);
  const std::size_t step = std::max<std::size_t>(1, triangles.size() / kMost);
  const double phases = static_cast<double>(positions.size());
  std::vector<Weighted> distances;
  std::vector<Weighted> angles;
  for (std::size_t p = 0; p < positions.size(); ++p) {
    const auto frame =
        phantom.frame(phantom.spec().rr_interval_s * static_cast<double>(p) / phases);
    std::vector<TriangleErrors> found((triangles.size() + step - 1) / step);
    parallel_for(found.size(), [&](std::size_t n) {
      std::array<Vec3, 3> corner;
      for (std::size_t c = 0; c < 3; ++c) {
        corner[c] = lps_from_workspace * positions[p][triangles[n * step][c]].cast<double>();
      }
      found[n] = triangle_errors(corner, *frame, structure, crease_band_mm);
    });
    for (const TriangleErrors& each : found) {
      for (int n = 0; n < each.count; ++n) {
        distances.push_back({each.distance[static_cast<std::size_t>(n)]});
      }
      if (each.angle >= 0) angles.push_back({each.angle});
    }
  }
  return summed(distances, angles, distances);
}

}  // namespace beatlas::assess
