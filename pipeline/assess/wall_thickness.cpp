#include "pipeline/assess/wall_thickness.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "pipeline/assess/statistics.h"
#include "pipeline/core/parallel.h"
#include "pipeline/phantom/ray.h"

namespace beatlas::assess {
namespace {

constexpr double kLongestMm = 80.0;      // of a ray through the wall
constexpr double kSeekMm = 12.0;         // of the package's endocardium around the true one
constexpr double kGapMm = 5.0;           // between the package's endocardium and its muscle
constexpr double kStepMm = 0.5;          // below the smallest voxel, so no wall is stepped over
constexpr double kTouchMm = 1e-6;        // a span that begins here begins at the endocardium
constexpr std::size_t kRaysATask = 128;  // rays a task

/// The field along a ray at one moment.
struct Along {
  const field::FieldQuery& query;
  double t_s;
  Vec3 origin;
  Vec3 direction;

  [[nodiscard]] double at(double s) const {
    return query.sample(origin + s * direction, t_s).distance_mm;
  }
  /// Between s values of different sign, to 1e-6 mm.
  [[nodiscard]] double zero(double low, double high) const {
    const bool low_inside = at(low) < 0.0;
    while (high - low > 1e-6) {
      const double middle = 0.5 * (low + high);
      ((at(middle) < 0.0) == low_inside ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }
  /// The first s in [from, to] at which the ray is inside (or no longer), refined; none if never.
  [[nodiscard]] std::optional<double> first(bool inside, double from, double to) const {
    if ((at(from) < 0.0) == inside) return from;
    for (double s = from; s < to; s += kStepMm) {
      if ((at(s + kStepMm) < 0.0) == inside) return zero(s, s + kStepMm);
    }
    return std::nullopt;
  }
};

/// Where the ray leaves the blood nearest to s = 0.
std::optional<double> endocardium(const Along& blood) {
  std::optional<double> best;
  bool inside = blood.at(-kSeekMm) < 0.0;
  for (double s = -kSeekMm; s < kSeekMm; s += kStepMm) {
    const bool next = blood.at(s + kStepMm) < 0.0;
    if (inside && !next) {
      const double found = blood.zero(s, s + kStepMm);
      if (!best || std::abs(found) < std::abs(*best)) best = found;
    }
    inside = next;
  }
  return best;
}

std::optional<double> package_thickness_mm(const Along& blood, const Along& muscle) {
  const auto inner = endocardium(blood);
  if (!inner) return std::nullopt;
  const auto entry = muscle.first(true, *inner, *inner + kGapMm);
  if (!entry) return std::nullopt;
  const auto outer = muscle.first(false, *entry + kTouchMm, *entry + kLongestMm);
  if (!outer) return std::nullopt;
  return *outer - *inner;
}

struct Ray {
  double truth_mm = 0;
  std::optional<double> package_mm;
};

}  // namespace

ThicknessErrors wall_thickness_errors(const field::FieldQuery& blood,
                                      const field::FieldQuery& muscle,
                                      const Affine& workspace_from_lps,
                                      const phantom::Phantom& truth, double share,
                                      const ThicknessOptions& options) {
  const auto frame = truth.frame(share * truth.spec().rr_interval_s);
  const phantom::Anatomy& anatomy = truth.spec().anatomy;
  const std::vector<Vec3> points = frame->sample_surface(Structure::LvBlood, options.spacing_mm);
  const auto near_rim = [&](const Vec3& lps) {
    return frame->crease_distance_mm(Structure::LvMyocardium, lps) < options.rim_mm;
  };
  const auto ray = [&](const Vec3& lps) -> std::optional<Ray> {
    if (near_rim(lps)) return std::nullopt;
    const Vec3 outward = frame->nearest(Structure::LvBlood, lps).outward;
    const std::vector<phantom::Span> spans =
        spans_in_lv_muscle(*frame, anatomy, lps, outward, {0.0, kLongestMm});
    // No muscle at the point: it lies on the base.
    if (spans.empty() || spans.front().from_mm > kTouchMm) return std::nullopt;
    const Vec3 exit = lps + spans.front().to_mm * outward;
    const double exit_z = (phantom::lps_from_heart(anatomy).inverse(Eigen::Isometry) * exit).z();
    if (near_rim(exit) || exit_z > frame->shape().lv_base_z_mm - kTouchMm) return std::nullopt;
    const Vec3 origin = workspace_from_lps * lps;
    const Vec3 direction = workspace_from_lps.linear() * outward;
    return Ray{spans.front().length_mm(),
               package_thickness_mm({blood, share * blood.rr_interval_s(), origin, direction},
                                    {muscle, share * muscle.rr_interval_s(), origin, direction})};
  };
  const std::size_t tasks = (points.size() + kRaysATask - 1) / kRaysATask;
  std::vector<std::vector<Ray>> found(tasks);
  parallel_for(tasks, [&](std::size_t task) {
    const std::size_t end = std::min(points.size(), (task + 1) * kRaysATask);
    for (std::size_t n = task * kRaysATask; n < end; ++n) {
      if (const auto each = ray(points[n])) found[task].push_back(*each);
    }
  });
  ThicknessErrors out;
  std::vector<Weighted> errors;
  double sum_mm = 0.0;
  for (const auto& rays : found) {
    for (const Ray& each : rays) {
      if (!each.package_mm) {
        ++out.missing;
        continue;
      }
      errors.push_back({*each.package_mm - each.truth_mm});
      sum_mm += each.truth_mm;
    }
  }
  out.points = static_cast<int>(errors.size());
  if (out.points == 0) return out;
  const DistanceStatistics statistics = pooled_statistics(errors, {});
  out.mean_mm = statistics.mean;
  out.p95_mm = statistics.p95;
  out.bias_mm = statistics.bias;
  out.true_mean_mm = sum_mm / out.points;
  return out;
}

}  // namespace beatlas::assess
