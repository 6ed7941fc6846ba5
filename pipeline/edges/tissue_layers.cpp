#include "pipeline/edges/tissue_layers.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "pipeline/core/box_share.h"

namespace beatlas::edges {
namespace {

/// Ends of tissues lie on a lattice of so many millimetres, and so do the profile's bins: shares of
/// voxels are looked up, and sums over bins that lie all in one tissue are known beforehand.
constexpr double kUnitMm = 0.05;
constexpr int units(double mm) { return static_cast<int>(mm / kUnitMm + (mm < 0 ? -0.5 : 0.5)); }

constexpr double kGainSpread = 0.05;       ///< of what shading leaves, standard deviation
constexpr int kThinnestWall = units(1.6);  ///< atria's walls are about 2 mm thick
constexpr int kMostWall = units(9);        ///< the profile sees no farther
constexpr int kRvWall = units(3);          ///< a search begins there
constexpr int kFarthestOff = units(5);     ///< of the edge
constexpr int kFirstStep = units(0.8);     ///< a search's, where it begins
constexpr int kNextStep = units(0.2);      ///< and at the next thickness
constexpr int kLastStep = units(0.1);
constexpr int kSigmaStep = units(0.1);  ///< to either side, for how fast cost rises
constexpr double kUntoldMm = 1;         ///< standard deviation where nothing tells the edge
constexpr int kNoWall = 0;
constexpr int kOnlyWall = units(50);  ///< no blood in sight
constexpr double kNearBloodMm = 2.5;  ///< so near it may come to the edge itself

constexpr int kFirstBin = units(SurfaceProfile::middle_mm(0));
constexpr int kBin = units(SurfaceProfile::kBinMm);
constexpr int kBins = static_cast<int>(SurfaceProfile::kBins);
constexpr int kInnermost = -kFarthestOff - kSigmaStep - kMostWall;  ///< end that is looked at
constexpr int kOutermost = kFarthestOff + kSigmaStep + units(kFatThicknessMm.back());

/// Sums over a profile's bins, each share being that of voxels inside of an end.
struct EndSums {
  double share = 0;    ///< weight * share
  double squares = 0;  ///< weight * share^2
  double seen = 0;     ///< weight * share * mean
  bool known = false;
};

/// A profile summed up, for any end of a tissue.
class ProfileSums {
 public:
  ProfileSums(const SurfaceProfile& profile, const Vec3& normal, const Vec3& spacing_mm)
      : reach_(static_cast<int>(0.5 * normal.cwiseAbs().dot(spacing_mm) / kUnitMm) + 1),
        share_(static_cast<std::size_t>(2 * reach_ + 1)) {
    for (std::size_t n = 0; n < share_.size(); ++n) {
      const int d = static_cast<int>(n) - reach_;
      share_[n] = box_share(0.5 * spacing_mm, d * kUnitMm, normal);
    }
    for (std::size_t n = 0; n < SurfaceProfile::kBins; ++n) {
      weight_[n] = profile.variance[n] > 0 ? 1 / profile.variance[n] : 0;
      seen_[n] = weight_[n] * profile.mean[n];
      weights_[n + 1] = weights_[n] + weight_[n];
      seens_[n + 1] = seens_[n] + seen_[n];
      squares_ += seen_[n] * profile.mean[n];
    }
  }

  [[nodiscard]] double weight() const { return weights_.back(); }
  [[nodiscard]] double seen() const { return seens_.back(); }
  [[nodiscard]] double squares() const { return squares_; }  ///< of what is seen

  [[nodiscard]] const EndSums& of(int end) const {
    EndSums& out = ends_[static_cast<std::size_t>(end - kInnermost)];
    if (out.known) return out;
    const auto [first, last] = mixed(end);
    out = {weights_[first], weights_[first], seens_[first], true};
    for (std::size_t n = first; n < last; ++n) {
      const double share = at(n, end);
      out.share += weight_[n] * share;
      out.squares += weight_[n] * share * share;
      out.seen += seen_[n] * share;
    }
    return out;
  }

  /// Of weight * share inside one end * share inside another one that lies no farther in.
  [[nodiscard]] double product(int inner, int outer) const {
    if (outer - inner >= 2 * reach_) return of(inner).share;
    const auto [first, last] = mixed(inner);
    double out = weights_[first];
    for (std::size_t n = first; n < last; ++n) out += weight_[n] * at(n, inner) * at(n, outer);
    return out;
  }

 private:
  /// Bins whose voxels an end may cut: [first, last).
  [[nodiscard]] std::pair<std::size_t, std::size_t> mixed(int end) const {
    const auto bin = [](int from) {
      const int n = from < 0 ? 0 : (from + kBin - 1) / kBin;
      return static_cast<std::size_t>(std::min(n, kBins));
    };
    return {bin(end - reach_ - kFirstBin), bin(end + reach_ - kFirstBin)};
  }

  [[nodiscard]] double at(std::size_t bin, int end) const {
    const int d = kFirstBin + kBin * static_cast<int>(bin) - end;
    const int entry = std::clamp(d, -reach_, reach_) + reach_;
    return share_[static_cast<std::size_t>(entry)];
  }

  int reach_;                  ///< beyond which a voxel lies on one side of an end
  std::vector<double> share_;  ///< [how far outside of the end + reach_]
  std::array<double, SurfaceProfile::kBins> weight_{};
  std::array<double, SurfaceProfile::kBins> seen_{};
  std::array<double, SurfaceProfile::kBins + 1> weights_{};  ///< of the bins before
  std::array<double, SurfaceProfile::kBins + 1> seens_{};
  double squares_ = 0;
  mutable std::array<EndSums, kOutermost - kInnermost + 1> ends_{};
};

/// Where tissues part.
struct Ends {
  int edge = 0;
  int wall = 0;
  double cost = std::numeric_limits<double>::infinity();
};

class Search {
 public:
  Search(const SurfaceProfile& profile, const LayerLevels& levels, const Vec3& normal,
         const Vec3& spacing_mm)
      : profile_(profile), levels_(levels), sums_(profile, normal, spacing_mm) {}

  /// Walls from which a search sets out: by where the innermost blood begins.
  [[nodiscard]] std::vector<int> walls() const {
    const double threshold = 0.5 * (levels_.blood + levels_.muscle);
    for (std::size_t n = SurfaceProfile::kBins; n-- > 0;) {
      const double place_mm = SurfaceProfile::middle_mm(n);
      if (!(profile_.variance[n] > 0) || place_mm > -1 || profile_.mean[n] < threshold) continue;
      if (place_mm < -kNearBloodMm) return {units(-place_mm)};
      return {kNoWall, kRvWall};
    }
    return {kOnlyWall};
  }

  /// The gain of known levels and the level beyond are linear once it is known where tissues part.
  [[nodiscard]] Ends at(int edge, int wall, int fat) const {
    constexpr double kOfGain = 1 / (kGainSpread * kGainSpread);
    // Known tissues are what lies inside of fat's end, of the edge, and of blood's end.
    const double fat_level = levels_.fat;
    const double muscle_level = levels_.muscle - levels_.fat;
    const EndSums& known = sums_.of(edge + fat);
    const EndSums& heart = sums_.of(edge);
    const double heart_known = fat > 0 ? sums_.product(edge, edge + fat) : heart.squares;
    double gain_gain = kOfGain + fat_level * fat_level * known.squares +
                       muscle_level * muscle_level * heart.squares +
                       2 * fat_level * muscle_level * heart_known;
    double gain_beyond =
        fat_level * (known.share - known.squares) + muscle_level * (heart.share - heart_known);
    double gain_seen = kOfGain + fat_level * known.seen + muscle_level * heart.seen;
    if (wall < kOnlyWall) {
      const double blood_level = levels_.blood - levels_.muscle;
      const EndSums& blood = sums_.of(edge - wall);
      const double blood_known = sums_.product(edge - wall, edge + fat);
      const double blood_heart = fat > 0 ? sums_.product(edge - wall, edge) : blood_known;
      gain_gain += blood_level * (blood_level * blood.squares + 2 * fat_level * blood_known +
                                  2 * muscle_level * blood_heart);
      gain_beyond += blood_level * (blood.share - blood_known);
      gain_seen += blood_level * blood.seen;
    }
    const double beyond_beyond =
        1 / (levels_.fat * levels_.fat) + sums_.weight() - 2 * known.share + known.squares;
    const double beyond_seen = sums_.seen() - known.seen;
    const double det = gain_gain * beyond_beyond - gain_beyond * gain_beyond;
    const double gain = (beyond_beyond * gain_seen - gain_beyond * beyond_seen) / det;
    const double level = (gain_gain * beyond_seen - gain_beyond * gain_seen) / det;
    return {edge, wall, kOfGain + sums_.squares() - gain * gain_seen - level * beyond_seen};
  }

  /// Halves its steps, from where it begins.
  [[nodiscard]] Ends refined(const Ends& begin, int fat, int first_step) const {
    const bool walled = begin.wall > kNoWall && begin.wall < kOnlyWall;
    Ends best = at(begin.edge, begin.wall, fat);
    Tried tried;  // none of these is better than the best of now
    for (int step = first_step; step >= kLastStep; step /= 2) {
      bool better = true;
      while (better) better = improve(step, fat, walled, tried, best);
    }
    return best;
  }

 private:
  /// Blood's end stays as the heart's moves, both move, or the wall thickens on both sides.
  static constexpr int kEdges = 2 * kFarthestOff + 1;
  static constexpr int kWalls = kMostWall + 1;
  static constexpr std::array<std::array<int, 2>, 8> kWays{
      {{-1, 0}, {1, 0}, {-1, -1}, {1, 1}, {0, -1}, {0, 1}, {-1, 1}, {1, -1}}};
  using Tried = std::bitset<kEdges * kWalls>;

  /// Looks one step around the best ends, each time from the best so far.
  /// @return whether there were better ones
  [[nodiscard]] bool improve(int step, int fat, bool walled, Tried& tried, Ends& best) const {
    bool better = false;
    for (const auto& [edge_way, wall_way] : kWays) {
      if (!walled && wall_way != 0) continue;
      const int edge = best.edge + step * edge_way;
      const int wall = best.wall + step * wall_way;
      if (std::abs(edge) > kFarthestOff) continue;
      if (walled && (wall < kThinnestWall || wall > kMostWall)) continue;
      const int place = (edge + kFarthestOff) * kWalls + (walled ? wall : 0);
      if (tried[static_cast<std::size_t>(place)]) continue;
      tried.set(static_cast<std::size_t>(place));
      const Ends next = at(edge, wall, fat);
      if (!(next.cost < best.cost)) continue;
      best = next;
      better = true;
    }
    return better;
  }

  const SurfaceProfile& profile_;
  const LayerLevels& levels_;
  ProfileSums sums_;
};

}  // namespace

LayersByThickness fit_layers(const SurfaceProfile& profile, const LayerLevels& levels,
                             const Vec3& normal, const Vec3& spacing_mm,
                             const std::vector<std::size_t>& begin) {
  const Search search(profile, levels, normal, spacing_mm);
  std::array<int, kFatThicknessMm.size()> fat{};
  std::transform(kFatThicknessMm.begin(), kFatThicknessMm.end(), fat.begin(), units);
  std::array<Ends, kFatThicknessMm.size()> found;
  const auto keep = [&](std::size_t n, const Ends& ends) {
    if (ends.cost < found[n].cost) found[n] = ends;
  };
  for (const int wall : search.walls()) {
    for (const std::size_t from : begin) {
      const Ends first = search.refined({0, wall}, fat[from], kFirstStep);
      keep(from, first);
      Ends last = first;
      for (std::size_t n = from + 1; n < fat.size(); ++n) {
        last = search.refined(last, fat[n], kNextStep);
        keep(n, last);
      }
      last = first;
      for (std::size_t n = from; n-- > 0;) {
        last = search.refined(last, fat[n], kNextStep);
        keep(n, last);
      }
    }
  }
  LayersByThickness out;
  std::transform(found.begin(), found.end(), out.at.begin(), [](const Ends& ends) {
    return LayersAt{ends.edge * kUnitMm, ends.wall * kUnitMm, ends.cost};
  });
  const auto best = static_cast<std::size_t>(
      std::min_element(found.begin(), found.end(),
                       [](const Ends& a, const Ends& b) { return a.cost < b.cost; }) -
      found.begin());
  const auto beside = [&](int step) {
    return search.at(found[best].edge + step, found[best].wall, fat[best]).cost;
  };
  const double rise = 0.5 * (beside(kSigmaStep) + beside(-kSigmaStep)) - found[best].cost;
  constexpr double kStepMm = kSigmaStep * kUnitMm;
  out.edge_sigma_mm = kStepMm / std::sqrt(std::max(rise, std::pow(kStepMm / kUntoldMm, 2)));
  return out;
}

}  // namespace beatlas::edges
