#include "pipeline/ingest/phase_resampling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace beatlas::ingest {
namespace {

/// Shortest way from b to a around the cycle, -0.5..0.5.
double around(double a, double b) { return (a - b) - std::round(a - b); }

PhaseTaps copy_of(int frame) {
  PhaseTaps out;
  out.frame[0] = frame;
  out.weight[0] = 1;
  out.count = 1;
  return out;
}

class Knots {
 public:
  explicit Knots(const std::vector<double>& phases) : order_(phases.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    std::sort(order_.begin(), order_.end(), [&](int a, int b) {
      return phases[static_cast<std::size_t>(a)] < phases[static_cast<std::size_t>(b)];
    });
    for (const int index : order_) sorted_.push_back(phases[static_cast<std::size_t>(index)]);
  }
  [[nodiscard]] int count() const { return static_cast<int>(order_.size()); }
  [[nodiscard]] int frame(int knot) const { return order_[wrapped(knot)]; }
  /// Phase of a knot, unrolled: knot + count() lies one later.
  [[nodiscard]] double at(int knot) const {
    const double turns = std::floor(static_cast<double>(knot) / count());
    return sorted_[wrapped(knot)] + turns;
  }
  [[nodiscard]] int nearest(double phase) const {
    int best = 0;
    for (int knot = 1; knot < count(); ++knot) {
      if (std::abs(around(at(knot), phase)) < std::abs(around(at(best), phase))) best = knot;
    }
    return best;
  }

 private:
  [[nodiscard]] std::size_t wrapped(int knot) const {
    return static_cast<std::size_t>(((knot % count()) + count()) % count());
  }
  std::vector<int> order_;
  std::vector<double> sorted_;
};

PhaseTaps cubic(const Knots& knots, double phase) {
  int k =
      -1;  // the interval [k, k+1) around the cycle; -1 reaches from the last frame to the first
  while (k + 1 < knots.count() && knots.at(k + 1) <= phase) ++k;
  const double t0 = knots.at(k - 1);
  const double t1 = knots.at(k);
  const double t2 = knots.at(k + 1);
  const double t3 = knots.at(k + 2);
  const double h = t2 - t1;
  const double u = (phase - t1) / h;
  const double u2 = u * u;
  const double u3 = u2 * u;
  const double value1 = 2 * u3 - 3 * u2 + 1;
  const double value2 = 3 * u2 - 2 * u3;
  const double slope1 = (u3 - 2 * u2 + u) * h / (t2 - t0);
  const double slope2 = (u3 - u2) * h / (t3 - t1);
  PhaseTaps out;
  out.frame = {knots.frame(k - 1), knots.frame(k), knots.frame(k + 1), knots.frame(k + 2)};
  out.weight = {-slope1, value1 - slope2, value2 + slope1, slope2};
  out.count = 4;
  return out;
}

/// How far to turn the frames so that frame (p + turn) fits phase p / count best.
int best_turn(const Knots& knots) {
  int best = 0;
  double least = std::numeric_limits<double>::max();
  for (int turn = 0; turn < knots.count(); ++turn) {
    double cost = 0;
    for (int p = 0; p < knots.count(); ++p) {
      const double miss = around(knots.at(p + turn), static_cast<double>(p) / knots.count());
      cost += miss * miss;
    }
    if (cost < least - 1e-12) {
      least = cost;
      best = turn;
    }
  }
  return best;
}

}  // namespace

std::vector<PhaseTaps> resample_phases(const std::vector<double>& phases, int count) {
  const Knots knots(phases);
  std::vector<PhaseTaps> out;
  if (knots.count() < kLeastFramesToBlend && knots.count() == count) {
    const int turn = best_turn(knots);
    for (int p = 0; p < count; ++p) out.push_back(copy_of(knots.frame(p + turn)));
    return out;
  }
  for (int p = 0; p < count; ++p) {
    const double phase = static_cast<double>(p) / count;
    const int nearest = knots.nearest(phase);
    const double miss = std::abs(around(knots.at(nearest), phase)) * knots.count();
    if (knots.count() < kLeastFramesToBlend || miss <= kSamePhase) {
      out.push_back(copy_of(knots.frame(nearest)));
    } else {
      out.push_back(cubic(knots, phase));
    }
  }
  return out;
}

void blend_to(const std::vector<std::vector<float>>& frames, const PhaseTaps& taps, float* out) {
  const auto frame = [&](int tap) -> const std::vector<float>& {
    return frames[static_cast<std::size_t>(taps.frame[static_cast<std::size_t>(tap)])];
  };
  if (taps.count == 1) {
    std::copy(frame(0).begin(), frame(0).end(), out);
    return;
  }
  const std::size_t size = frame(0).size();
  for (std::size_t i = 0; i < size; ++i) {
    double sum = 0;
    for (int tap = 0; tap < taps.count; ++tap) {
      sum += taps.weight[static_cast<std::size_t>(tap)] * static_cast<double>(frame(tap)[i]);
    }
    out[i] = static_cast<float>(sum);
  }
}

}  // namespace beatlas::ingest
