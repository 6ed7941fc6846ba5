#include "pipeline/assess/validate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "pipeline/assess/statistics.h"
#include "pipeline/assess/zero_level.h"
#include "pipeline/core/parallel.h"
#include "pipeline/phantom/truth.h"
#include "runtime/base/error.h"
#include "runtime/field/field_query.h"

namespace beatlas::assess {
namespace {

constexpr double kGridMm = 0.1;      // what rounding in a file may move a voxel by
constexpr double kRrS = 2e-3;        // R-R intervals are written in whole milliseconds
constexpr std::size_t kChunk = 512;  // points a task

struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
};

Grid source_grid(const atlas::Manifest& manifest) {
  return {manifest.source_size, manifest.source_lps_from_index};
}

std::array<Vec3, 8> corners(const Grid& grid) {
  std::array<Vec3, 8> out;
  for (int n = 0; n < 8; ++n) {
    out[n] = grid.mm((n & 1) ? grid.size[0] - 1 : 0, (n & 2) ? grid.size[1] - 1 : 0,
                     (n & 4) ? grid.size[2] - 1 : 0);
  }
  return out;
}

/// The same voxels, in whatever order of rows, columns and slices a file brought them.
bool same_lattice(const Grid& a, const Grid& b) {
  Index3 size_a = a.size;
  Index3 size_b = b.size;
  std::sort(size_a.begin(), size_a.end());
  std::sort(size_b.begin(), size_b.end());
  if (size_a != size_b) return false;
  const std::array<Vec3, 8> corners_b = corners(b);
  for (const Vec3& corner : corners(a)) {
    if (std::none_of(corners_b.begin(), corners_b.end(),
                     [&](const Vec3& other) { return (corner - other).norm() < kGridMm; })) {
      return false;
    }
  }
  return true;
}

void check_same_phantom(const atlas::Manifest& manifest, const phantom::Phantom& truth) {
  const phantom::PhantomSpec& spec = truth.spec();
  const std::string other = "the truth is that of another phantom: ";
  const std::string advice = "; give the truth written with the images this package was made from";
  if (!same_lattice(source_grid(manifest), spec.imaging_grid())) {
    throw_invalid(other + "its image grid is not the package's source grid" + advice);
  }
  if (manifest.frame_times_s.size() != static_cast<std::size_t>(spec.phases)) {
    throw_invalid(other + "it has " + std::to_string(spec.phases) +
                  " frames and the package's source " +
                  std::to_string(manifest.frame_times_s.size()) + advice);
  }
  if (!(std::abs(manifest.rr_interval_s - spec.rr_interval_s) <= kRrS)) {
    throw_invalid(other + "its R-R interval is not the package's" + advice);
  }
}

/// One structure against the truth.
class Comparison {
 public:
  Comparison(const atlas::Manifest& manifest,
             const std::shared_ptr<const atlas::FieldPayload>& payload,
             const phantom::Phantom& truth, const ValidateLimits& limits)
      : structure_(payload->structure),
        query_(payload, manifest.rr_interval_s),
        truth_(truth),
        limits_(limits),
        grid_(source_grid(manifest)),
        workspace_from_lps_(manifest.workspace_from_lps),
        lps_from_workspace_(manifest.workspace_from_lps.inverse()) {}

  [[nodiscard]] PhaseErrors phase(int p, int phases) const {
    const double share = static_cast<double>(p) / phases;
    const double t_package = share * query_.rr_interval_s();
    const auto frame = truth_.frame(share * truth_.spec().rr_interval_s);
    PhaseErrors out;
    out.dice = dice(*frame, t_package);
    const std::vector<SurfacePoint> surface = zero_level(query_, t_package);
    const std::vector<Weighted> one = package_to_truth(surface, *frame);
    const std::vector<Weighted> other = truth_to_package(surface, *frame, t_package);
    const DistanceStatistics statistics = pooled_statistics(one, other);
    out.mean_mm = statistics.mean;
    out.p95_mm = statistics.p95;
    out.hausdorff_mm = statistics.maximum;
    out.bias_mm = statistics.bias;
    out.points = surface.empty() ? 0 : static_cast<int>(one.size() + other.size());
    return out;
  }

 private:
  /// Runs over the points in tasks and keeps those that `measure` gives a value for, in order.
  template <class Points, class Measure>
  std::vector<Weighted> collect(const Points& points, const Measure& measure) const {
    const std::size_t tasks = (points.size() + kChunk - 1) / kChunk;
    std::vector<std::vector<Weighted>> found(tasks);
    parallel_for(tasks, [&](std::size_t task) {
      const std::size_t end = std::min(points.size(), (task + 1) * kChunk);
      for (std::size_t n = task * kChunk; n < end; ++n) {
        if (const std::optional<Weighted> value = measure(points[n])) found[task].push_back(*value);
      }
    });
    std::vector<Weighted> out;
    for (const auto& each : found) out.insert(out.end(), each.begin(), each.end());
    return out;
  }

  std::vector<Weighted> package_to_truth(const std::vector<SurfacePoint>& surface,
                                         const phantom::Frame& frame) const {
    return collect(surface, [&](const SurfacePoint& point) -> std::optional<Weighted> {
      const phantom::Nearest nearest = frame.nearest(structure_, lps_from_workspace_ * point.x);
      if (frame.crease_distance_mm(structure_, nearest.point) < limits_.crease_band_mm) return {};
      return Weighted{nearest.distance_mm, point.area_mm2};
    });
  }

  std::vector<Weighted> truth_to_package(const std::vector<SurfacePoint>& surface,
                                         const phantom::Frame& frame, double t_package) const {
    const std::vector<Vec3> samples = frame.sample_surface(structure_, limits_.sample_spacing_mm);
    return collect(samples, [&](const Vec3& lps) -> std::optional<Weighted> {
      if (frame.crease_distance_mm(structure_, lps) < limits_.crease_band_mm) return {};
      const Vec3 x = workspace_from_lps_ * lps;
      const field::FieldSample sample = query_.sample(x, t_package);
      double distance = sample.distance_mm;
      if (!sample.in_band) {
        // The field knows only that the surface is far; the points of the surface know how far.
        double far = std::numeric_limits<double>::infinity();
        for (const SurfacePoint& point : surface) far = std::min(far, (point.x - x).norm());
        if (std::isfinite(far)) distance = std::copysign(far, distance);
      }
      return Weighted{-distance, 1.0};
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
  field::FieldQuery query_;
  const phantom::Phantom& truth_;
  const ValidateLimits& limits_;
  Grid grid_;
  Affine workspace_from_lps_;
  Affine lps_from_workspace_;
};

const std::vector<double>& volume_curve(const atlas::Manifest& manifest, Structure structure,
                                        int phases) {
  const std::string name(structure_name(structure));
  for (const atlas::StructureEntry& entry : manifest.structures) {
    if (entry.name != name) continue;
    if (entry.volume_ml.size() != static_cast<std::size_t>(phases)) {
      throw_invalid("the package's volume curve of " + name +
                    " has another number of phases than "
                    "its field; build the package again");
    }
    return entry.volume_ml;
  }
  throw_invalid("the package has a field of " + name + " but no volume curve; build it again");
}

double ejection_fraction(const std::vector<double>& curve) {
  const auto [low, high] = std::minmax_element(curve.begin(), curve.end());
  return *high > 0.0 ? 1.0 - *low / *high : 0.0;
}

void check_limits(const ValidateLimits& limits, ValidationReport& report) {
  const auto fail = [&](const std::string& where, const char* what, double value, double limit,
                        const char* side) {
    char text[160];
    std::snprintf(text, sizeof text, ": %s is %.4g, %s the limit of %.4g", what, value, side,
                  limit);
    report.failures.push_back(where + text);
  };
  const auto at_most = [&](const std::string& where, const char* what, double value,
                           const std::optional<double>& limit) {
    if (limit && !(std::abs(value) <= *limit)) fail(where, what, value, *limit, "beyond");
  };
  for (const StructureErrors& structure : report.structures) {
    const std::string name(structure_name(structure.structure));
    for (std::size_t p = 0; p < structure.phases.size(); ++p) {
      const PhaseErrors& errors = structure.phases[p];
      const std::string where = name + " in phase " + std::to_string(p);
      if (errors.points == 0) {
        report.failures.push_back(where + ": the package has no surface");
        continue;
      }
      if (!(errors.dice > 0.0)) {
        report.failures.push_back(where + ": the package and the truth do not overlap");
      }
      at_most(where, "mean_mm", errors.mean_mm, limits.max_mean_mm);
      at_most(where, "p95_mm", errors.p95_mm, limits.max_p95_mm);
      at_most(where, "hausdorff_mm", errors.hausdorff_mm, limits.max_hausdorff_mm);
      at_most(where, "bias_mm", errors.bias_mm, limits.max_bias_mm);
      at_most(where, "volume_error_ml", errors.volume_error_ml, limits.max_volume_error_ml);
      if (limits.min_dice && !(errors.dice >= *limits.min_dice)) {
        fail(where, "dice", errors.dice, *limits.min_dice, "below");
      }
    }
    if (structure.ejection_fraction_error) {
      at_most(name, "ejection_fraction_error", *structure.ejection_fraction_error,
              limits.max_ejection_fraction_error);
    }
  }
  report.passed = report.failures.empty();
}

}  // namespace

ValidationReport validate(const Candidate& candidate, const phantom::Phantom& truth,
                          const ValidateLimits& limits, StageContext& context) {
  if (!(limits.sample_spacing_mm >= 0.3 && limits.sample_spacing_mm <= 20.0) ||
      !(limits.crease_band_mm >= 0.0)) {
    throw_invalid("sample_spacing_mm must be from 0.3 to 20 and crease_band_mm not negative");
  }
  check_same_phantom(candidate.manifest, truth);
  if (candidate.fields.empty()) {
    throw_invalid("no field to validate was opened; the scenes palpation and full hold fields");
  }
  ValidationReport report;
  std::size_t done = 0;
  for (const auto& field : candidate.fields) {
    const Structure structure = field->structure;
    const int phases = field->phases;
    const std::vector<double>& curve = volume_curve(candidate.manifest, structure, phases);
    const Comparison comparison(candidate.manifest, field, truth, limits);
    StructureErrors errors;
    errors.structure = structure;
    std::vector<double> true_curve;
    for (int p = 0; p < phases; ++p) {
      context.check_cancelled();
      PhaseErrors phase = comparison.phase(p, phases);
      true_curve.push_back(truth.volume_ml(structure, truth.spec().rr_interval_s * p / phases));
      phase.volume_error_ml = curve[static_cast<std::size_t>(p)] - true_curve.back();
      errors.phases.push_back(phase);
      context.progress((static_cast<double>(done) + (p + 1.0) / phases) /
                       static_cast<double>(candidate.fields.size()));
    }
    if (structure == Structure::LvBlood || structure == Structure::RvBlood) {
      errors.ejection_fraction_error = ejection_fraction(curve) - ejection_fraction(true_curve);
    }
    report.structures.push_back(std::move(errors));
    ++done;
  }
  check_limits(limits, report);
  return report;
}

ValidationReport validate(const atlas::Atlas& atlas, const phantom::Phantom& truth,
                          const ValidateLimits& limits, StageContext& context) {
  Candidate candidate{atlas.manifest(), {}};
  for (Structure structure : kAllStructures) {
    if (auto field = atlas.field(structure)) candidate.fields.push_back(std::move(field));
  }
  return validate(candidate, truth, limits, context);
}

nlohmann::json report_to_json(const ValidationReport& report) {
  nlohmann::json structures = nlohmann::json::array();
  for (const StructureErrors& structure : report.structures) {
    nlohmann::json phases = nlohmann::json::array();
    for (const PhaseErrors& errors : structure.phases) {
      phases.push_back({{"dice", errors.dice},
                        {"volume_error_ml", errors.volume_error_ml},
                        {"mean_mm", errors.mean_mm},
                        {"p95_mm", errors.p95_mm},
                        {"hausdorff_mm", errors.hausdorff_mm},
                        {"bias_mm", errors.bias_mm},
                        {"points", errors.points}});
    }
    nlohmann::json entry{{"name", std::string(structure_name(structure.structure))},
                         {"phases", phases}};
    if (structure.ejection_fraction_error) {
      entry["ejection_fraction_error"] = *structure.ejection_fraction_error;
    }
    structures.push_back(std::move(entry));
  }
  return {{"structures", structures}, {"passed", report.passed}, {"failures", report.failures}};
}

}  // namespace beatlas::assess
