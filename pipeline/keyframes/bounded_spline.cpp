#include "pipeline/keyframes/bounded_spline.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace beatlas::keyframes {
namespace {

constexpr double kMostBeyond = 0.0025;  // of the largest key's volume
constexpr double kEven = 1.25;          // of intervals side by side, longest to shortest
constexpr int kLooks = 16;              // an interval
constexpr int kAtRest = 2;  // how much a slope may be held: 0 not, 1 as a monotone one's

class Bounded {
 public:
  Bounded(const std::vector<double>& at, const std::vector<VolumeOf>& volumes)
      : at_(at), volumes_(volumes), spline_(at), hold_(at.size(), 0) {
    double most = -1;
    for (const VolumeOf& volume : volumes) {
      std::vector<double>& keys = at_keys_.emplace_back();
      for (std::size_t n = 0; n < at.size(); ++n) keys.push_back(volume(key(n)));
      const auto [low, high] = std::minmax_element(keys.begin(), keys.end());
      if (*high - *low <= most) continue;
      most = *high - *low;
      beats_most_ = at_keys_.size() - 1;
    }
  }

  BoundedSpline made() {
    while (hold_more()) {
      std::map<std::size_t, Eigen::VectorXd> held;
      for (std::size_t n = 0; n < at_.size(); ++n) {
        if (hold_[n] > 0) held.emplace(n, hold_[n] == kAtRest ? at_rest() : monotone(n));
      }
      spline_ = PeriodicSpline(at_, held);
    }
    BoundedSpline out{spline_, {}};
    for (std::size_t n = 0; n < at_.size(); ++n) {
      if (hold_[n] > 0) out.held.push_back(n);
    }
    return out;
  }

 private:
  [[nodiscard]] std::size_t before(std::size_t n) const {
    return (n + at_.size() - 1) % at_.size();
  }
  [[nodiscard]] std::size_t after(std::size_t n) const { return (n + 1) % at_.size(); }
  [[nodiscard]] Eigen::VectorXd at_rest() const {
    return Eigen::VectorXd::Zero(at_index(at_.size()));
  }
  [[nodiscard]] Eigen::VectorXd key(std::size_t n) const {
    return Eigen::VectorXd::Unit(at_index(at_.size()), at_index(n));
  }

  /// Of the interval that begins at the key.
  [[nodiscard]] bool is_uneven(std::size_t n) const {
    const auto [low, high] =
        std::minmax({spline_.gap(before(n)), spline_.gap(n), spline_.gap(after(n))});
    return high > kEven * low;
  }

  [[nodiscard]] bool overshoots(std::size_t n) const {
    for (std::size_t s = 0; s < volumes_.size(); ++s) {
      const std::vector<double>& keys = at_keys_[s];
      const auto [low, high] = std::minmax(keys[n], keys[after(n)]);
      const double slack = kMostBeyond * *std::max_element(keys.begin(), keys.end());
      for (int look = 1; look < kLooks; ++look) {
        const double share = at_[n] + spline_.gap(n) * look / kLooks;
        const double volume = volumes_[s](spline_.weights(share));
        if (volume > high + slack || volume < low - slack) return true;
      }
    }
    return false;
  }

  /// Holds the ends of intervals that overshoot, or holds them more. False if there is none to
  /// hold.
  [[nodiscard]] bool hold_more() {
    std::set<std::size_t> more;
    for (std::size_t n = 0; n < at_.size(); ++n) {
      const bool can = hold_[n] < kAtRest || hold_[after(n)] < kAtRest;
      if (!can || !is_uneven(n) || !overshoots(n)) continue;
      more.insert({n, after(n)});
    }
    for (const std::size_t n : more) hold_[n] = std::min(hold_[n] + 1, kAtRest);
    return !more.empty();
  }

  [[nodiscard]] Eigen::VectorXd monotone(std::size_t n) const {
    const VolumeOf& volume = volumes_[beats_most_];
    const std::vector<double>& keys = at_keys_[beats_most_];
    const double left = spline_.gap(before(n));
    const double right = spline_.gap(n);
    const double ml_back = (keys[n] - keys[before(n)]) / left;
    const double ml_on = (keys[after(n)] - keys[n]) / right;
    double wanted = 0;  // [ml] per cycle, as are the other slopes of volume
    if (ml_back * ml_on > 0) {
      const double by_back = left + 2 * right;
      const double by_on = 2 * left + right;
      wanted = (by_back + by_on) / (by_back / ml_back + by_on / ml_on);
    }
    // What the volume changes by along each chord, at the key.
    const Eigen::VectorXd back = (key(n) - key(before(n))) / left;
    const Eigen::VectorXd on = (key(after(n)) - key(n)) / right;
    const double step = 1e-4 * std::min(left, right);
    const auto rate = [&](const Eigen::VectorXd& along) {
      return (volume(key(n) + step * along) - volume(key(n) - step * along)) / (2 * step);
    };
    const double rate_back = rate(back);
    const double rate_on = rate(on);
    const double apart = rate_back - rate_on;
    // Chords along which it changes alike leave the choice: as of a parabola through the keys.
    const bool alike = std::abs(apart) <= 1e-6 * (std::abs(rate_back) + std::abs(rate_on));
    const double part = alike ? right / (left + right) : (wanted - rate_on) / apart;
    const double of_back = std::clamp(part, 0.0, 1.0);
    return of_back * back + (1 - of_back) * on;
  }

  const std::vector<double>& at_;
  const std::vector<VolumeOf>& volumes_;
  std::vector<std::vector<double>> at_keys_;  // [shape][key] ml
  std::size_t beats_most_ = 0;
  PeriodicSpline spline_;
  std::vector<int> hold_;
};

}  // namespace

BoundedSpline bounded_spline(const std::vector<double>& at, const std::vector<VolumeOf>& volumes) {
  return Bounded(at, volumes).made();
}

}  // namespace beatlas::keyframes
