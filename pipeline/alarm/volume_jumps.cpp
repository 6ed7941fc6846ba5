#include "pipeline/alarm/volume_jumps.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace beatlas::alarm {
namespace {

constexpr int kFinePhases = 10;  ///< from here on a beat has no corner between two phases
constexpr int kRunShare = 8;     ///< of the cycle

struct Foretold {
  double low = 0;
  double high = 0;
};

class Cyclic {
 public:
  explicit Cyclic(const std::vector<double>& values) : values_(values) {}
  [[nodiscard]] int count() const { return static_cast<int>(values_.size()); }
  double operator()(int phase) const {
    return values_[static_cast<std::size_t>(((phase % count()) + count()) % count())];
  }

 private:
  const std::vector<double>& values_;
};

/// Of phase first + at in the run of `count` phases from `first`.
Foretold foretold(const Cyclic& value, int first, int count, int at) {
  const double before = value(first - 1);
  const double after = value(first + count);
  const double from_before = before + (at + 1) * (before - value(first - 2));
  const double from_after = after + (count - at) * (after - value(first + count + 1));
  const auto [low, high] = std::minmax(before, after);
  const auto [lower, higher] = std::minmax(from_before, from_after);
  if (value.count() < kFinePhases) return {std::min(low, lower), std::max(high, higher)};
  return {std::min(low, higher), std::max(high, lower)};
}

/// The run's worst phase, if all of it is beyond on one side; `least` gets the least excess.
VolumeJump judge(const Cyclic& value, int phases, int first, int count, double& least) {
  VolumeJump jump{first, count, first, 0};
  double up = 0;
  double down = 0;
  for (int at = 0; at < count; ++at) {
    const Foretold range = foretold(value, first, count, at);
    const double above = value(first + at) - range.high;
    const double below = range.low - value(first + at);
    up = at == 0 ? above : std::min(up, above);
    down = at == 0 ? below : std::min(down, below);
    const double excess = std::max(above, below);
    if (at == 0 || excess > std::abs(jump.beyond)) {
      jump.beyond = above > below ? above : -below;
      jump.worst = (first + at) % phases;
    }
  }
  least = std::max(up, down);
  return jump;
}

}  // namespace

std::vector<VolumeJump> volume_jumps(const std::vector<double>& curve, double limit) {
  std::vector<VolumeJump> jumps;
  const int n = static_cast<int>(curve.size());
  const double largest = n > 0 ? *std::max_element(curve.begin(), curve.end()) : 0;
  if (n < 5 || !(largest > 0)) return jumps;
  std::vector<double> mended = curve;
  for (int round = 0; round < n; ++round) {
    const Cyclic value(mended);
    VolumeJump worst;
    double most = limit * largest;
    bool found = false;
    for (int count = 1; count <= std::max(1, n / kRunShare); ++count) {
      for (int first = 0; first < n; ++first) {
        double least = 0;
        const VolumeJump jump = judge(value, n, first, count, least);
        if (!(least > most)) continue;
        most = least;
        worst = jump;
        found = true;
      }
    }
    if (!found) break;
    // What counts is the run taken back to a straight line between its neighbours.
    std::vector<double> next = mended;
    const double before = value(worst.first - 1);
    const double after = value(worst.first + worst.count);
    for (int at = 0; at < worst.count; ++at) {
      next[static_cast<std::size_t>((worst.first + at) % n)] =
          before + (after - before) * (at + 1) / (worst.count + 1);
    }
    worst.beyond /= largest;
    jumps.push_back(worst);
    mended = std::move(next);
  }
  return jumps;
}

double closing_step(const std::vector<double>& curve) {
  const int n = static_cast<int>(curve.size());
  if (n < kFinePhases) return 0;
  const double largest = *std::max_element(curve.begin(), curve.end());
  if (!(largest > 0)) return 0;
  const Cyclic value(curve);
  const auto step = [&](int phase) { return value(phase + 1) - value(phase); };
  const auto [low, high] = std::minmax({0.0, step(n - 2), step(0)});
  return std::max({0.0, step(n - 1) - high, low - step(n - 1)}) / largest;
}

}  // namespace beatlas::alarm
