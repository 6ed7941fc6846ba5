#include "pipeline/assess/motion_error.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "pipeline/assess/statistics.h"
#include "pipeline/core/parallel.h"
#include "pipeline/phantom/material.h"
#include "pipeline/phantom/motion.h"

namespace beatlas::assess {
namespace {

constexpr std::size_t kMovedATask = 256;  // vertices a task

/// Length of each part of a vector along and across a normal.
struct Split {
  double whole;
  double tangential;
};

Split split(const Vec3& error, const Vec3& normal) {
  return {error.norm(), (error - normal.dot(error) * normal).norm()};
}

/// The true heart at the phases and between them.
struct Moments {
  Moments(const phantom::Phantom& truth, int phases, int parts) : count_a_phase(parts) {
    const double rr_s = truth.spec().rr_interval_s;
    for (int n = 0; n < phases * parts; ++n) {
      const double t_s = rr_s * n / (phases * parts);
      s.push_back(std::clamp(phantom::volume_loss(t_s, rr_s), 0.0, 1.0));
      frames.push_back(std::make_unique<const phantom::Frame>(truth.spec().anatomy, s.back()));
    }
  }
  int count_a_phase;
  std::vector<double> s;
  std::vector<std::unique_ptr<const phantom::Frame>> frames;
};

/// The face of the LV's wall that a place lies on, as mural share; none if on neither.
std::optional<double> face_at(const phantom::Anatomy& anatomy, const Vec3& heart_mm, double s,
                              double within_mm) {
  for (const double mural : {0.0, 1.0}) {
    const phantom::Ellipsoid shell = phantom::lv_shell(anatomy, s, mural);
    if ((phantom::nearest_point(shell, heart_mm) - heart_mm).norm() < within_mm) return mural;
  }
  return std::nullopt;
}

struct MotionFound {
  std::vector<Split> package;
  std::vector<Split> normal_only;
};

class Follower {
 public:
  Follower(const atlas::SurfacePayload& surface, const Affine& workspace_from_lps,
           const phantom::Phantom& truth, const MotionOptions& options)
      : surface_(surface),
        anatomy_(truth.spec().anatomy),
        options_(options),
        moments_(truth, static_cast<int>(surface.positions.size()), options.parts),
        lps_from_heart_(phantom::lps_from_heart(anatomy_)),
        heart_from_workspace_((workspace_from_lps * lps_from_heart_).inverse(Eigen::Isometry)) {}

  [[nodiscard]] bool follow(std::size_t vertex, MotionFound& found) const {
    const double start_s = moments_.s.front();
    const Vec3 start = at(0, vertex);
    const auto face = face_at(anatomy_, start, start_s, options_.on_wall_mm);
    if (!face) return false;
    const phantom::MaterialPoint muscle = phantom::material_at(anatomy_, start, *face, start_s);
    const Vec3 muscle_start = phantom::position_mm(anatomy_, muscle, start_s);
    const Vec3 lps = lps_from_heart_ * muscle_start;
    const phantom::Frame& first = *moments_.frames.front();
    if ((muscle_start - start).norm() > options_.on_wall_mm ||
        std::abs(first.distance_mm(surface_.structure, lps)) > 1e-6 ||
        first.crease_distance_mm(surface_.structure, lps) < options_.rim_mm) {
      return false;
    }
    Vec3 along_normals = lps;
    for (std::size_t p = 1; p < surface_.positions.size(); ++p) {
      for (int part = 1; part <= moments_.count_a_phase; ++part) {
        const std::size_t n = (p - 1) * static_cast<std::size_t>(moments_.count_a_phase) +
                              static_cast<std::size_t>(part);
        along_normals = moments_.frames[n]->nearest(surface_.structure, along_normals).point;
      }
      const double s = moments_.s[p * static_cast<std::size_t>(moments_.count_a_phase)];
      const Vec3 muscle_now = phantom::position_mm(anatomy_, muscle, s);
      const Vec3 normal =
          phantom::lv_shell(anatomy_, s, muscle.mural).gradient(muscle_now).normalized();
      found.package.push_back(split((at(p, vertex) - start) - (muscle_now - muscle_start), normal));
      found.normal_only.push_back(
          split(lps_from_heart_.inverse(Eigen::Isometry) * along_normals - muscle_now, normal));
    }
    return true;
  }

 private:
  [[nodiscard]] Vec3 at(std::size_t phase, std::size_t vertex) const {
    return heart_from_workspace_ * surface_.positions[phase][vertex].cast<double>();
  }

  const atlas::SurfacePayload& surface_;
  const phantom::Anatomy& anatomy_;
  const MotionOptions& options_;
  Moments moments_;
  Affine lps_from_heart_;
  Affine heart_from_workspace_;
};

}  // namespace

MotionErrors motion_errors(const atlas::SurfacePayload& surface, const Affine& workspace_from_lps,
                           const phantom::Phantom& truth, const MotionOptions& options) {
  MotionErrors out;
  if (truth.spec().anatomy.infarct.present || surface.positions.size() < 2) return out;
  const Follower follower(surface, workspace_from_lps, truth, options);
  const std::size_t vertices = surface.positions.front().size();
  const std::size_t tasks = (vertices + kMovedATask - 1) / kMovedATask;
  std::vector<MotionFound> found(tasks);
  std::vector<int> points(tasks);
  parallel_for(tasks, [&](std::size_t task) {
    const std::size_t end = std::min(vertices, (task + 1) * kMovedATask);
    for (std::size_t v = task * kMovedATask; v < end; ++v) {
      points[task] += follower.follow(v, found[task]) ? 1 : 0;
    }
  });
  std::vector<Weighted> whole;
  std::vector<Weighted> tangential;
  double normal_only_mm = 0;
  double normal_only_tangential_mm = 0;
  for (const MotionFound& part : found) {
    for (const Split& each : part.package) {
      whole.push_back({each.whole});
      tangential.push_back({each.tangential});
    }
    for (const Split& each : part.normal_only) {
      normal_only_mm += each.whole;
      normal_only_tangential_mm += each.tangential;
    }
  }
  for (const int count : points) out.points += count;
  if (whole.empty()) return out;
  const DistanceStatistics all = pooled_statistics(whole, {});
  const DistanceStatistics across = pooled_statistics(tangential, {});
  out.mean_mm = all.mean;
  out.p95_mm = all.p95;
  out.tangential_mean_mm = across.mean;
  out.tangential_p95_mm = across.p95;
  out.normal_only_mean_mm = normal_only_mm / static_cast<double>(whole.size());
  out.normal_only_tangential_mean_mm =
      normal_only_tangential_mm / static_cast<double>(whole.size());
  out.tangential_share = out.normal_only_tangential_mean_mm > 0
                             ? out.tangential_mean_mm / out.normal_only_tangential_mean_mm
                             : 0.0;
  return out;
}

}  // namespace beatlas::assess
