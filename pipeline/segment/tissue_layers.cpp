#include "pipeline/segment/tissue_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pipeline/core/box_share.h"

namespace beatlas::segment {
namespace {

constexpr double kGainSpread = 0.05;  ///< of what shading leaves, standard deviation
constexpr double kLeastWallMm = 1.6;  ///< atria's walls are about 2 mm thick
constexpr double kMostWallMm = 9;     ///< the profile sees no farther
constexpr double kRvWallMm = 3;       ///< a search begins there
constexpr double kMostOffMm = 5;      ///< of the edge
constexpr double kFirstStepMm = 0.8;  ///< a search's, where it begins
constexpr double kNextStepMm = 0.2;   ///< and at the next thickness
constexpr double kLastStepMm = 0.05;
constexpr double kSigmaStepMm = 0.1;  ///< to either side, for how fast cost rises
constexpr double kUntoldMm = 1;       ///< standard deviation where nothing tells the edge
constexpr double kNoWallMm = 0;
constexpr double kOnlyWallMm = 50;    ///< no blood in sight
constexpr double kNearBloodMm = 2.5;  ///< so near it may come to the edge itself

/// Share of voxels inside a plane by how far outside their middles lie: a table.
class ShareTable {
 public:
  ShareTable(const Vec3& normal, const Vec3& spacing_mm)
      : half_mm_(0.5 * normal.cwiseAbs().dot(spacing_mm)) {
    for (std::size_t n = 0; n < kEntries; ++n) {
      const double d = half_mm_ * (2 * static_cast<double>(n) / (kEntries - 1) - 1);
      share_[n] = box_share(0.5 * spacing_mm, d, normal);
    }
  }

  [[nodiscard]] double operator()(double outside_mm) const {
    const double at = (outside_mm / half_mm_ + 1) * (0.5 * (kEntries - 1));
    if (!(at > 0)) return 1;
    if (at >= kEntries - 1) return 0;
    const auto n = static_cast<std::size_t>(at);
    return share_[n] + (at - static_cast<double>(n)) * (share_[n + 1] - share_[n]);
  }

 private:
  static constexpr std::size_t kEntries = 97;
  double half_mm_;
  std::array<double, kEntries> share_{};
};

class Search {
 public:
  Search(const SurfaceProfile& profile, const LayerLevels& levels, const ShareTable& share)
      : levels_(levels), share_(share) {
    for (std::size_t n = 0; n < SurfaceProfile::kBins; ++n) {
      if (!(profile.variance[n] > 0)) continue;
      place_[count_] = SurfaceProfile::middle_mm(n);
      mean_[count_] = profile.mean[n];
      weight_[count_] = 1 / profile.variance[n];
      ++count_;
    }
  }

  /// Walls from which a search sets out: by where the innermost blood begins.
  [[nodiscard]] std::vector<double> walls() const {
    const double threshold = 0.5 * (levels_.blood + levels_.muscle);
    for (std::size_t n = count_; n-- > 0;) {
      if (place_[n] > -1 || mean_[n] < threshold) continue;
      if (place_[n] < -kNearBloodMm) return {-place_[n]};
      return {kNoWallMm, kRvWallMm};
    }
    return {kOnlyWallMm};
  }

  /// The gain of known levels and the level beyond are linear once it is known where tissues part.
  [[nodiscard]] LayersAt at(double edge_mm, double wall_mm, double fat_mm) const {
    constexpr double kOfGain = 1 / (kGainSpread * kGainSpread);
    double gain_gain = kOfGain;
    double gain_beyond = 0;
    double beyond_beyond = 1 / (levels_.fat * levels_.fat);
    double gain_seen = kOfGain;
    double beyond_seen = 0;
    double squares = kOfGain;
    for (std::size_t n = 0; n < count_; ++n) {
      const double d = place_[n] - edge_mm;
      const double heart = share_(d);
      const double blood = wall_mm < kOnlyWallMm ? share_(d + wall_mm) : 0;
      const double known = fat_mm > 0 ? share_(d - fat_mm) : heart;
      const double level =
          levels_.blood * blood + levels_.muscle * (heart - blood) + levels_.fat * (known - heart);
      const double beyond = 1 - known;
      const double weight = weight_[n];
      gain_gain += weight * level * level;
      gain_beyond += weight * level * beyond;
      beyond_beyond += weight * beyond * beyond;
      gain_seen += weight * level * mean_[n];
      beyond_seen += weight * beyond * mean_[n];
      squares += weight * mean_[n] * mean_[n];
    }
    const double det = gain_gain * beyond_beyond - gain_beyond * gain_beyond;
    const double gain = (beyond_beyond * gain_seen - gain_beyond * beyond_seen) / det;
    const double level = (gain_gain * beyond_seen - gain_beyond * gain_seen) / det;
    return {edge_mm, wall_mm, squares - gain * gain_seen - level * beyond_seen};
  }

  /// Halves its steps, from where it begins.
  [[nodiscard]] LayersAt refined(const LayersAt& begin, double fat_mm, double step_mm) const {
    const bool walled = begin.wall_mm > kNoWallMm && begin.wall_mm < kOnlyWallMm;
    LayersAt best = at(begin.edge_mm, begin.wall_mm, fat_mm);
    for (double step = step_mm; step > kLastStepMm; step *= 0.5) {
      for (bool better = true; better;) {
        better = false;
        for (const auto& [edge_way, wall_way] : kWays) {
          if (!walled && wall_way != 0) continue;
          const double edge = best.edge_mm + step * edge_way;
          const double wall = best.wall_mm + step * wall_way;
          if (std::abs(edge) > kMostOffMm) continue;
          if (walled && (wall < kLeastWallMm || wall > kMostWallMm)) continue;
          const LayersAt tried = at(edge, wall, fat_mm);
          if (!(tried.cost < best.cost)) continue;
          best = tried;
          better = true;
        }
      }
    }
    return best;
  }

 private:
  /// Blood's end stays as the heart's moves, both move, or the wall thickens on both sides.
  static constexpr std::array<std::array<double, 2>, 8> kWays{
      {{-1, 0}, {1, 0}, {-1, -1}, {1, 1}, {0, -1}, {0, 1}, {-1, 1}, {1, -1}}};

  const LayerLevels& levels_;
  const ShareTable& share_;
  std::size_t count_ = 0;
  std::array<double, SurfaceProfile::kBins> place_{};
  std::array<double, SurfaceProfile::kBins> mean_{};
  std::array<double, SurfaceProfile::kBins> weight_{};
};

}  // namespace

LayersByThickness fit_layers(const SurfaceProfile& profile, const LayerLevels& levels,
                             const Vec3& normal, const Vec3& spacing_mm,
                             const std::vector<std::size_t>& begin) {
  const ShareTable share(normal, spacing_mm);
  const Search search(profile, levels, share);
  LayersByThickness out;
  out.at.fill({0, 0, std::numeric_limits<double>::infinity()});
  const auto keep = [&](std::size_t n, const LayersAt& found) {
    if (found.cost < out.at[n].cost) out.at[n] = found;
  };
  for (const double wall : search.walls()) {
    for (const std::size_t from : begin) {
      const LayersAt first = search.refined({0, wall, 0}, kFatThicknessMm[from], kFirstStepMm);
      keep(from, first);
      LayersAt last = first;
      for (std::size_t n = from + 1; n < kFatThicknessMm.size(); ++n) {
        last = search.refined(last, kFatThicknessMm[n], kNextStepMm);
        keep(n, last);
      }
      last = first;
      for (std::size_t n = from; n-- > 0;) {
        last = search.refined(last, kFatThicknessMm[n], kNextStepMm);
        keep(n, last);
      }
    }
  }
  const auto best = static_cast<std::size_t>(
      std::min_element(out.at.begin(), out.at.end(),
                       [](const LayersAt& a, const LayersAt& b) { return a.cost < b.cost; }) -
      out.at.begin());
  const auto beside = [&](double step) {
    return search.at(out.at[best].edge_mm + step, out.at[best].wall_mm, kFatThicknessMm[best]).cost;
  };
  const double rise = 0.5 * (beside(kSigmaStepMm) + beside(-kSigmaStepMm)) - out.at[best].cost;
  out.edge_sigma_mm =
      kSigmaStepMm / std::sqrt(std::max(rise, std::pow(kSigmaStepMm / kUntoldMm, 2)));
  return out;
}

}  // namespace beatlas::segment
