#include "pipeline/assess/map_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "pipeline/assess/statistics.h"
#include "pipeline/core/parallel.h"
#include "pipeline/phantom/ray.h"

namespace beatlas::assess {
namespace {

constexpr double kLongestMm = 80;          // of a ray through the wall
constexpr double kTouchMm = 1e-6;          // a span that begins here begins at the endocardium
constexpr double kLookMm = 0.25;           // below the thinnest wall
constexpr std::size_t kMappedATask = 128;  // vertices a task

/// The true heart at a moment.
class TrueWall {
 public:
  TrueWall(const phantom::Phantom& truth, double share, const MapOptions& options)
      : frame_(truth.frame(share * truth.spec().rr_interval_s)),
        anatomy_(truth.spec().anatomy),
        heart_from_lps_(phantom::lps_from_heart(anatomy_).inverse(Eigen::Isometry)),
        options_(options) {}

  /// None where there is no wall, or its end is too near to the rim.
  [[nodiscard]] std::optional<double> thickness_mm(Structure structure, const Vec3& lps) const {
    return structure == Structure::RvBlood ? of_rv_mm(lps) : of_lv_mm(structure, lps);
  }

  [[nodiscard]] int segment(const Vec3& lps) const {
    const Vec3 heart_mm = heart_from_lps_ * lps;
    const double apex_mm = anatomy_.scale * anatomy_.apex_mm;
    const double share = (heart_mm.z() - apex_mm) / (frame_->shape().lv_base_z_mm - apex_mm);
    if (share < 0.08) return 17;
    // x lies towards the RV, y towards the front.
    const double turns = std::atan2(heart_mm.x(), heart_mm.y()) / (2 * std::numbers::pi);
    const auto sector = [turns](int count) {
      return (static_cast<int>(std::lround(turns * count)) + count) % count;
    };
    if (share < 1.0 / 3) return 13 + sector(4);
    return (share < 2.0 / 3 ? 7 : 1) + sector(6);
  }

 private:
  [[nodiscard]] std::optional<double> of_lv_mm(Structure structure, const Vec3& lps) const {
    const Vec3 at = frame_->nearest(structure, lps).point;
    if ((at - lps).norm() > options_.off_wall_mm || near_rim(at)) return std::nullopt;
    const phantom::Nearest inner = frame_->nearest(Structure::LvBlood, at);
    const double away = (inner.point - at).norm();
    if (away > kTouchMm) {  // the epicardium
      const bool is_base = height_mm(at) > frame_->shape().lv_base_z_mm - kTouchMm;
      if (is_base || near_rim(inner.point)) return std::nullopt;
      return away;
    }
    const std::vector<phantom::Span> spans =
        spans_in_lv_muscle(*frame_, anatomy_, at, inner.outward, {0.0, kLongestMm});
    if (spans.empty() || spans.front().from_mm > kTouchMm) return std::nullopt;
    const Vec3 exit = at + spans.front().to_mm * inner.outward;
    const bool through_base = height_mm(exit) > frame_->shape().lv_base_z_mm - kTouchMm;
    if (through_base || near_rim(exit)) return std::nullopt;
    return spans.front().length_mm();
  }

  /// Along the endocardium's normal through the free wall and out of the heart.
  [[nodiscard]] std::optional<double> of_rv_mm(const Vec3& lps) const {
    const phantom::Nearest inner = frame_->nearest(Structure::RvBlood, lps);
    const auto near_its_rim = [&](const Vec3& at) {
      return frame_->crease_distance_mm(phantom::Part::RvWall, at) < options_.rim_mm;
    };
    if ((inner.point - lps).norm() > options_.off_wall_mm || near_its_rim(inner.point)) {
      return std::nullopt;
    }
    const auto along = [&](double way_mm) -> Vec3 { return inner.point + way_mm * inner.outward; };
    const auto in_wall = [&](double way_mm) {
      return frame_->contains(phantom::Part::RvWall, along(way_mm));
    };
    double low = kTouchMm;
    if (!in_wall(low)) return std::nullopt;
    double high = low + kLookMm;
    while (in_wall(high)) {
      low = high;
      high += kLookMm;
      if (high > kLongestMm) return std::nullopt;
    }
    while (high - low > kTouchMm) {
      const double middle = 0.5 * (low + high);
      (in_wall(middle) ? low : high) = middle;
    }
    const bool leaves_heart = !frame_->contains(Structure::Heart, along(high + kTouchMm));
    if (!leaves_heart || near_its_rim(along(high))) return std::nullopt;
    return high;
  }

  [[nodiscard]] bool near_rim(const Vec3& lps) const {
    return frame_->crease_distance_mm(Structure::LvMyocardium, lps) < options_.rim_mm;
  }
  [[nodiscard]] double height_mm(const Vec3& lps) const { return (heart_from_lps_ * lps).z(); }

  std::shared_ptr<const phantom::Frame> frame_;
  const phantom::Anatomy& anatomy_;
  Affine heart_from_lps_;
  const MapOptions& options_;
};

struct MapFound {
  std::vector<Weighted> errors;
  double true_sum_mm = 0;
  int missing = 0;
  int named = 0;
  int rightly = 0;
};

}  // namespace

MapErrors map_errors(const atlas::SurfaceMapPayload& map, const atlas::SurfacePayload& surface,
                     const Affine& workspace_from_lps, const phantom::Phantom& truth,
                     const MapOptions& options) {
  const std::size_t phases = surface.positions.size();
  const std::size_t vertices = surface.positions.front().size();
  const Affine lps_from_workspace = workspace_from_lps.inverse(Eigen::Isometry);
  const std::size_t every =
      std::max<std::size_t>(1, vertices / static_cast<std::size_t>(options.most_vertices));
  const std::size_t asked = (vertices + every - 1) / every;
  const std::size_t tasks_a_phase = (asked + kMappedATask - 1) / kMappedATask;
  std::vector<TrueWall> walls;
  for (std::size_t p = 0; p < phases; ++p) {
    walls.emplace_back(truth, static_cast<double>(p) / static_cast<double>(phases), options);
  }
  std::vector<MapFound> found(phases * tasks_a_phase);
  parallel_for(found.size(), [&](std::size_t task) {
    const std::size_t p = task / tasks_a_phase;
    const std::size_t begin = (task % tasks_a_phase) * kMappedATask;
    MapFound& own = found[task];
    for (std::size_t n = begin; n < std::min(asked, begin + kMappedATask); ++n) {
      const std::size_t v = n * every;
      const Vec3 lps = lps_from_workspace * surface.positions[p][v].cast<double>();
      const auto told_mm = static_cast<double>(map.thickness_mm[p][v]);
      if (p == 0 && told_mm > 0 && map.segment[v] > 0) {
        ++own.named;
        own.rightly += walls[p].segment(lps) == map.segment[v] ? 1 : 0;
      }
      const std::optional<double> true_mm = walls[p].thickness_mm(map.structure, lps);
      if (!true_mm) continue;
      if (!(told_mm > 0)) {
        ++own.missing;
        continue;
      }
      own.errors.push_back({told_mm - *true_mm});
      own.true_sum_mm += *true_mm;
    }
  });
  MapErrors out;
  std::vector<Weighted> errors;
  int rightly = 0;
  for (const MapFound& part : found) {
    errors.insert(errors.end(), part.errors.begin(), part.errors.end());
    out.thickness_true_mean_mm += part.true_sum_mm;
    out.missing += part.missing;
    out.named += part.named;
    rightly += part.rightly;
  }
  out.points = static_cast<int>(errors.size());
  if (out.named > 0) out.segments_percent = 100.0 * rightly / out.named;
  if (errors.empty()) return out;
  const DistanceStatistics statistics = pooled_statistics(errors, {});
  out.thickness_mean_mm = statistics.mean;
  out.thickness_p95_mm = statistics.p95;
  out.thickness_bias_mm = statistics.bias;
  out.thickness_true_mean_mm /= out.points;
  return out;
}

}  // namespace beatlas::assess
