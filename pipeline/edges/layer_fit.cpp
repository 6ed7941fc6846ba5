#include "pipeline/edges/layer_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>

#include "pipeline/edges/outline.h"

namespace beatlas::edges {
namespace {

constexpr double kMuscleSpread =
    0.15;                             ///< of muscle's level, as a share of what parts it from blood
constexpr double kFatSpread = 0.1;    ///< of fat's level, as a share of what parts it from muscle
constexpr double kSureLayer = 12;     ///< by which the sum of squares falls, in variances
constexpr double kLeastInsidePx = 1;  ///< of muscle that has to be seen
constexpr double kMostOutsidePx = 2;  ///< labels do not miss more than that
constexpr double kMostThickPx = 10;
constexpr double kLeastThickPx = 0.08;    ///< less is the scanner's own blur
constexpr double kFinestPx = 0.06;        ///< of the search
constexpr double kNothingToldPx = 0.625;  ///< standard deviation where nothing tells the edge
constexpr double kThinPx = 0.3;           ///< where it begins
constexpr double kMuscleRange = 0.45;     ///< of what parts it from blood: so far off it is none

struct Fit {
  double cost = 0;
  double muscle = 0;
  double fat = 0;
  double beyond = 0;
};

class LayerSearch {
 public:
  LayerSearch(const AcrossProfile& profile, const LayerLevels& levels)
      : profile_(profile), levels_(levels) {
    std::size_t first = 0;
    while (first < AcrossProfile::kBins && !(profile.weight[first] > 0)) ++first;
    least_edge_px_ = AcrossProfile::kFromPx + AcrossProfile::kBinPx * static_cast<double>(first) +
                     kLeastInsidePx;
    const double contrast = levels.blood - levels.muscle;
    of_muscle_ = 1 / std::pow(kMuscleSpread * contrast, 2);
    of_fat_ = 1 / std::pow(kFatSpread * (levels.fat - levels.muscle), 2);
    of_beyond_ = 1 / std::pow(levels.fat, 2);
  }

  [[nodiscard]] double least_edge_px() const { return least_edge_px_; }

  /// Levels are linear in the profile once it is known where they part.
  [[nodiscard]] Fit at(double edge_px, double thick_px) const {
    Eigen::Matrix3d normal = Eigen::Vector3d(of_muscle_, of_fat_, of_beyond_).asDiagonal();
    Eigen::Vector3d right(of_muscle_ * levels_.muscle, of_fat_ * levels_.fat, 0);
    double squares =
        of_muscle_ * levels_.muscle * levels_.muscle + of_fat_ * levels_.fat * levels_.fat;
    const double precision = 1 / (levels_.noise * levels_.noise);
    for (std::size_t n = 0; n < AcrossProfile::kBins; ++n) {
      if (!(profile_.weight[n] > 0)) continue;
      const Eigen::Vector3d share = shares(AcrossProfile::middle_px(n) - edge_px, thick_px);
      const double weight = precision * profile_.weight[n];
      normal.noalias() += weight * share * share.transpose();
      right += weight * profile_.mean[n] * share;
      squares += weight * profile_.mean[n] * profile_.mean[n];
    }
    const Eigen::Vector3d level = normal.llt().solve(right);
    return {squares - right.dot(level), level[0], level[1], level[2]};
  }

  /// Halves its steps from half a pixel on. @param edge_px, thick_px where it begins, and ends
  /// @param thick whether there is a layer
  Fit refine(double& edge_px, double& thick_px, bool thick) const {
    Fit best = at(edge_px, thick_px);
    for (double step = 0.5; step > kFinestPx; step *= 0.5) {
      for (bool better = true; better;) {
        better = false;
        for (const auto& [de, dt] : kWays) {
          if (!thick && dt != 0) continue;
          const double edge = edge_px + step * de;
          const double thickness = thick_px + step * dt;
          if (edge < least_edge_px_ || edge > kMostOutsidePx || thickness < 0 ||
              thickness > kMostThickPx) {
            continue;
          }
          const Fit tried = at(edge, thickness);
          if (!(tried.cost < best.cost)) continue;
          best = tried;
          edge_px = edge;
          thick_px = thickness;
          better = true;
        }
      }
    }
    return best;
  }

  /// How well the edge is known, the layer's thickness beside it: by what profiles a little off
  /// would show.
  [[nodiscard]] double edge_sigma_px(double edge_px, double thick_px, const Fit& fit) const {
    constexpr double kStepPx = 2 * kFinestPx;
    const double thick = std::max(thick_px, kStepPx);
    Eigen::Matrix2d normal = Eigen::Matrix2d::Identity() / (kNothingToldPx * kNothingToldPx);
    const double precision = 1 / (levels_.noise * levels_.noise);
    for (std::size_t n = 0; n < AcrossProfile::kBins; ++n) {
      if (!(profile_.weight[n] > 0)) continue;
      const double d = AcrossProfile::middle_px(n);
      const auto shown = [&](double edge, double layer) {
        return shares(d - edge, layer).dot(Eigen::Vector3d(fit.muscle, fit.fat, fit.beyond));
      };
      const Eigen::Vector2d slope(
          (shown(edge_px + kStepPx, thick) - shown(edge_px - kStepPx, thick)) / (2 * kStepPx),
          (shown(edge_px, thick + kStepPx) - shown(edge_px, thick - kStepPx)) / (2 * kStepPx));
      normal += precision * profile_.weight[n] * slope * slope.transpose();
    }
    return std::sqrt(normal.inverse()(0, 0));
  }

 private:
  /// The outer end of the layer stays as its inner one moves, or moves with it.
  static constexpr std::array<std::array<double, 2>, 6> kWays{
      {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, 1}, {1, -1}}};

  /// Of muscle, fat and what lies beyond, so far outside of muscle's edge.
  [[nodiscard]] Eigen::Vector3d shares(double beyond_edge_px, double thick_px) const {
    const double within = ramp(static_cast<float>(beyond_edge_px), 0).coverage;
    const double to_end =
        thick_px > 0 ? ramp(static_cast<float>(beyond_edge_px - thick_px), 0).coverage : within;
    return {within, to_end - within, 1 - to_end};
  }

  const AcrossProfile& profile_;
  const LayerLevels& levels_;
  double least_edge_px_ = 0;
  double of_muscle_ = 0;
  double of_fat_ = 0;
  double of_beyond_ = 0;
};

double told(const AcrossProfile& profile) {
  double out = 0;
  for (const double weight : profile.weight) out += weight > 0 ? 1 : 0;
  return out;
}

/// Whether what lies right inside the edge is muscle.
bool is_muscle(const AcrossProfile& profile, const LayerLevels& levels, double edge_px) {
  double sum = 0;
  double weights = 0;
  constexpr double kMixed = 0.5;  // pixels: a voxel's half
  for (std::size_t n = 0; n < AcrossProfile::kBins; ++n) {
    const double d = AcrossProfile::middle_px(n) - edge_px;
    if (d < -kMixed - 2 || d > -kMixed) continue;
    sum += profile.weight[n] * profile.mean[n];
    weights += profile.weight[n];
  }
  return weights > 0 &&
         std::abs(sum / weights - levels.muscle) < kMuscleRange * (levels.blood - levels.muscle);
}

}  // namespace

std::optional<FatLayer> fit_fat_layer(const AcrossProfile& profile, const LayerLevels& levels) {
  const LayerSearch search(profile, levels);
  if (search.least_edge_px() > 0) return {};
  double edge_px = 0;
  double none = 0;
  const Fit alone = search.refine(edge_px, none, false);
  const double count = told(profile);
  if (alone.cost < count) return {};  // as well as noise lets it
  // A thin rim about that edge, and a thick layer from where the profile leaves muscle.
  double best_edge = std::max(search.least_edge_px(), edge_px - 2 * kThinPx);
  double best_thick = kThinPx;
  Fit best = search.refine(best_edge, best_thick, true);
  const double half = 0.5 * (levels.muscle + levels.fat);
  for (std::size_t n = 1; n < AcrossProfile::kBins; ++n) {
    if (!(profile.weight[n - 1] > 0) || profile.mean[n - 1] >= half || profile.mean[n] < half) {
      continue;
    }
    std::size_t end = n;
    while (end < AcrossProfile::kBins && profile.mean[end] >= half) ++end;
    double edge = AcrossProfile::middle_px(n) - 0.5 * AcrossProfile::kBinPx;
    double thick = AcrossProfile::kBinPx * static_cast<double>(end - n);
    if (edge < search.least_edge_px() || edge > kMostOutsidePx) continue;
    const Fit tried = search.refine(edge, thick, true);
    if (!(tried.cost < best.cost)) continue;
    best = tried;
    best_edge = edge;
    best_thick = thick;
  }
  if (alone.cost - best.cost < kSureLayer || best_thick < kLeastThickPx) return {};
  if (best.fat - std::max(best.muscle, best.beyond) < 0.5 * (levels.fat - levels.muscle) ||
      !is_muscle(profile, levels, best_edge)) {
    return {};
  }
  return FatLayer{best_edge, best_thick, search.edge_sigma_px(best_edge, best_thick, best)};
}

}  // namespace beatlas::edges
