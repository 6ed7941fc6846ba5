#include "pipeline/assess/compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "pipeline/assess/statistics.h"
#include "pipeline/assess/zero_level.h"
#include "pipeline/core/parallel.h"

namespace beatlas::assess {
namespace {

constexpr std::size_t kPointsATask = 512;  // points a task

struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
};

/// What the package's field says at a point of the true surface, against the truth.
struct AtTruth {
  double distance_mm = 0;  ///< + where the package is larger
  double angle_deg = 0;
  double velocity_mm_s = 0;
};

/// One structure against the truth.
class Comparison {
 public:
  Comparison(const atlas::Manifest& manifest, const field::FieldQuery& query,
             const phantom::Phantom& truth, const CompareOptions& options)
      : structure_(query.payload().structure),
        query_(query),
        truth_(truth),
        options_(options),
        grid_(source_grid(manifest)),
        workspace_from_lps_(manifest.workspace_from_lps),
        lps_from_workspace_(manifest.workspace_from_lps.inverse()) {}

  [[nodiscard]] PhaseErrors phase(int p, int phases) const {
    const double share = static_cast<double>(p) / phases;
    const double t_package = share * query_.rr_interval_s();
    const double t_truth = share * truth_.spec().rr_interval_s;
    const auto frame = truth_.frame(t_truth);
    PhaseErrors out;
    out.dice = dice(*frame, t_package);
    const std::vector<SurfacePoint> surface = zero_level(query_, t_package);
    const std::vector<Weighted> one = package_to_truth(surface, *frame);
    std::vector<Weighted> other;
    std::vector<Weighted> angles;
    std::vector<Weighted> velocities;
    for (const AtTruth& at : truth_to_package(surface, *frame, t_package, t_truth)) {
      other.push_back({at.distance_mm});
      angles.push_back({at.angle_deg});
      velocities.push_back({at.velocity_mm_s});
    }
    set_distances(pooled_statistics(one, other), out);
    const DistanceStatistics normal = pooled_statistics(angles, {});
    out.normal_mean_deg = normal.mean;
    out.normal_p95_deg = normal.p95;
    const DistanceStatistics velocity = pooled_statistics(velocities, {});
    out.velocity_mean_mm_s = velocity.mean;
    out.velocity_p95_mm_s = velocity.p95;
    out.points = surface.empty() ? 0 : static_cast<int>(one.size() + other.size());
    return out;
  }

 private:
  /// Runs over the points in tasks and keeps those that `measure` gives a value for, in order.
  template <class Value, class Points, class Measure>
  static std::vector<Value> collect(const Points& points, const Measure& measure) {
    const std::size_t tasks = (points.size() + kPointsATask - 1) / kPointsATask;
    std::vector<std::vector<Value>> found(tasks);
    parallel_for(tasks, [&](std::size_t task) {
      const std::size_t end = std::min(points.size(), (task + 1) * kPointsATask);
      for (std::size_t n = task * kPointsATask; n < end; ++n) {
        if (const std::optional<Value> value = measure(points[n])) found[task].push_back(*value);
      }
    });
    std::vector<Value> out;
    for (const auto& each : found) out.insert(out.end(), each.begin(), each.end());
    return out;
  }

  std::vector<Weighted> package_to_truth(const std::vector<SurfacePoint>& surface,
                                         const phantom::Frame& frame) const {
    return collect<Weighted>(surface, [&](const SurfacePoint& point) -> std::optional<Weighted> {
      const phantom::Nearest nearest = frame.nearest(structure_, lps_from_workspace_ * point.x);
      if (frame.crease_distance_mm(structure_, nearest.point) < options_.crease_band_mm) return {};
      return Weighted{nearest.distance_mm, point.area_mm2};
    });
  }

  std::vector<AtTruth> truth_to_package(const std::vector<SurfacePoint>& surface,
                                        const phantom::Frame& frame, double t_package,
                                        double t_truth) const {
    const std::vector<Vec3> samples = frame.sample_surface(structure_, options_.sample_spacing_mm);
    return collect<AtTruth>(samples, [&](const Vec3& lps) -> std::optional<AtTruth> {
      if (frame.crease_distance_mm(structure_, lps) < options_.crease_band_mm) return {};
      const Vec3 x = workspace_from_lps_ * lps;
      const field::FieldSample sample = query_.sample(x, t_package);
      double distance = sample.distance_mm;
      if (!sample.in_band) {
        // The field knows only that the surface is far; the points of the surface know how far.
        double far = std::numeric_limits<double>::infinity();
        for (const SurfacePoint& point : surface) far = std::min(far, (point.x - x).norm());
        if (std::isfinite(far)) distance = std::copysign(far, distance);
      }
      const Vec3 normal = workspace_from_lps_.linear() * frame.nearest(structure_, lps).outward;
      return AtTruth{-distance, angle_deg(query_.normal(sample, x), normal),
                     field::FieldQuery::normal_velocity_mm_s(sample) -
                         truth_.velocity_mm_s(structure_, lps, t_truth)};
    });
  }

  double dice(const phantom::Frame& frame, double t_package) const {
    const Bounds bounds = index_bounds(frame);
    Index3 first{};
    Index3 last{};
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = static_cast<int>(
          std::clamp(std::floor(bounds.low[axis]), 0.0, static_cast<double>(grid_.size[axis])));
      last[axis] = static_cast<int>(std::clamp(std::ceil(bounds.high[axis]), -1.0,
                                               static_cast<double>(grid_.size[axis] - 1)));
    }
    if (last[2] < first[2]) return 0.0;
    struct Counts {
      std::size_t package = 0, truth = 0, both = 0;
    };
    std::vector<Counts> slices(static_cast<std::size_t>(last[2] - first[2] + 1));
    parallel_for(slices.size(), [&](std::size_t slice) {
      Counts& counts = slices[slice];
      const int k = first[2] + static_cast<int>(slice);
      for (int j = first[1]; j <= last[1]; ++j) {
        for (int i = first[0]; i <= last[0]; ++i) {
          const Vec3 lps = grid_.mm(i, j, k);
          const bool in_truth = frame.contains(structure_, lps);
          const bool in_package =
              query_.sample(workspace_from_lps_ * lps, t_package).distance_mm < 0.0;
          counts.truth += in_truth;
          counts.package += in_package;
          counts.both += in_truth && in_package;
        }
      }
    });
    Counts sum;
    for (const Counts& counts : slices) {
      sum.package += counts.package;
      sum.truth += counts.truth;
      sum.both += counts.both;
    }
    const std::size_t total = sum.package + sum.truth;
    return total == 0 ? 0.0 : 2.0 * static_cast<double>(sum.both) / static_cast<double>(total);
  }

  /// Indices of the source's grid outside of which neither knows the structure.
  Bounds index_bounds(const phantom::Frame& frame) const {
    constexpr double kCoarseMm = 3.0;
    Bounds out;
    const Affine index_from_lps = grid_.mm_from_index.inverse();
    Bounds truth;
    for (const Vec3& lps : frame.sample_surface(structure_, kCoarseMm)) {
      truth.add(index_from_lps * lps);
    }
    // Samples may stop a spacing short of an extreme.
    const Vec3 margin = 2.0 * kCoarseMm * grid_.spacing_mm().cwiseInverse();
    out.add(truth.low - margin);
    out.add(truth.high + margin);
    const atlas::FieldPayload& payload = query_.payload();
    const Index3& blocks = payload.block_count;
    const double edge_mm = payload.voxel_mm * atlas::FieldPayload::kBlockEdge;
    for (std::size_t n = 0; n < payload.blocks.size(); ++n) {
      if (payload.blocks[n] == atlas::FieldPayload::kOutside) continue;
      const int b = static_cast<int>(n);
      const Vec3 low = payload.origin_mm + edge_mm * Vec3(b % blocks[0], b / blocks[0] % blocks[1],
                                                          b / (blocks[0] * blocks[1]));
      for (int corner = 0; corner < 8; ++corner) {
        // The spline reaches two samples beyond a block; a quarter of a block covers them.
        const Vec3 side((corner & 1) ? 1.25 : -0.25, (corner & 2) ? 1.25 : -0.25,
                        (corner & 4) ? 1.25 : -0.25);
        out.add(index_from_lps * (lps_from_workspace_ * (low + edge_mm * side)));
      }
    }
    return out;
  }

  Structure structure_;
  const field::FieldQuery& query_;
  const phantom::Phantom& truth_;
  const CompareOptions& options_;
  Grid grid_;
  Affine workspace_from_lps_;
  Affine lps_from_workspace_;
};

}  // namespace

Grid source_grid(const atlas::Manifest& manifest) {
  return {manifest.source_size, manifest.source_lps_from_index};
}

PhaseErrors compare_phase(const atlas::Manifest& manifest, const field::FieldQuery& query,
                          const phantom::Phantom& truth, int p, int phases,
                          const CompareOptions& options) {
  return Comparison(manifest, query, truth, options).phase(p, phases);
}

}  // namespace beatlas::assess
