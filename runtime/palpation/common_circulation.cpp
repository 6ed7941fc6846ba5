#include "runtime/palpation/common_circulation.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace beatlas::palpation {
namespace {

/// Steps of a beat in which the start is found.
constexpr int kStartSteps = 1000;
/// Of what the circulation lags behind, or is ahead by, in a tick.
constexpr double kMadeUp = 0.01;
/// It is slowed by no more than this share of its pace, and no more of a beat is made up for at
/// once.
constexpr double kMostSlowed = 0.1;
constexpr double kMostBehind = 0.05;
/// As far above the wall as it may come towards a finger in a tick.
constexpr double kClearM = 1e-3;
/// Farther out an atlas's field need not know how far: nothing there touches.
constexpr double kFarM = 4e-3;

double wrapped(double phase) noexcept { return phase - std::floor(phase); }

/// The nearer way round the cycle, -0.5..0.5.
double way(double from, double to) noexcept { return std::remainder(to - from, 1.0); }

}  // namespace

CommonCirculation::CommonCirculation(const PalpationParameters& parameters, double end_diastole,
                                     std::size_t fingers)
    : trainer_(parameters, fingers),
      natural_(parameters, 1),
      end_diastole_(end_diastole),
      count_(fingers) {
  // A heart's clock begins at phase 0: so does the circulation.
  const double step_s = 60 / parameters.circulation.heart_rate_per_min / kStartSteps;
  const double due = wrapped(-end_diastole_);
  for (int n = 0; n < 2 * kStartSteps; ++n) {
    (void)natural_.tick(step_s, {});
    (void)trainer_.tick(step_s, {});
    if (std::abs(way(natural_.signals().phase, due)) < 0.75 / kStartSteps) break;
  }
  answer();
}

void CommonCirculation::tell(std::size_t finger, const Vec3& place_mm, double depth_m,
                             double phase) noexcept {
  Told told{.phase = std::isfinite(phase) ? wrapped(phase) : 0};
  if (place_mm.allFinite() && std::isfinite(depth_m)) {
    told.place_mm = {place_mm.x(), place_mm.y(), place_mm.z()};
    told.depth_m = depth_m;
  }
  told_[finger].write(told);
}

void CommonCirculation::lift(std::size_t finger) noexcept { told_[finger].write({}); }

CommonCirculation::Felt CommonCirculation::felt(std::size_t finger) noexcept {
  Answer& read = read_[finger];
  (void)answer_.try_read(read);
  return {.pressure_n_per_m = read.pressure_n_per_m,
          .wall_m = read.wall_m,
          .given_m = read.given_m[finger],
          .shortening_ratio = read.shortening_ratio};
}

void CommonCirculation::advance() noexcept {
  if (advancing_.test_and_set(std::memory_order_acquire)) return;
  double phase = -1;
  for (std::size_t n = count_; n-- > 0;) {
    (void)told_[n].try_read(heard_[n]);
    if (heard_[n].phase >= 0) phase = heard_[n].phase;
  }
  if (phase >= 0) advance_to(phase);
  advancing_.clear(std::memory_order_release);
}

void CommonCirculation::advance_to(double phase) noexcept {
  const double ahead = last_phase_ >= 0 ? way(last_phase_, phase) : 0;
  const Signals& now = trainer_.signals();
  const double behind = way(now.phase, wrapped(phase - end_diastole_));
  // Where another finger leads from now on, its heart may be a tick behind.
  if (last_phase_ < 0 || ahead > 0) last_phase_ = phase;
  const double beat_s = 60 / std::max(1.0, now.heart_rate_per_min);
  const double made_up = kMadeUp * std::clamp(behind, -kMostBehind, kMostBehind);
  const double step_s = beat_s * std::max(ahead + made_up, (1 - kMostSlowed) * ahead);
  if (ahead > 0 && step_s > 0) {
    constexpr double kLongestS = 0.1;
    std::array<Finger, kMostFingers> fingers;
    const double shift_m = now.wall_m - natural_.signals().wall_m;
    for (std::size_t n = 0; n < count_; ++n) {
      const auto& [x, y, z] = heard_[n].place_mm;
      const double depth_m = heard_[n].depth_m;
      fingers[n].place_mm = Vec3(x, y, z);
      fingers[n].depth_m = depth_m - natural_.signals().wall_m;
      // What does not touch the moving wall displaces nothing, however little it moves there.
      if (depth_m + shift_m <= 0 || depth_m < -kFarM) {
        fingers[n].depth_m = std::min(fingers[n].depth_m, -now.wall_m - kClearM);
      }
    }
    (void)natural_.tick(std::min(step_s, kLongestS), {});
    (void)trainer_.tick(std::min(step_s, kLongestS), std::span(fingers).first(count_));
    answer();
  }
}

void CommonCirculation::answer() noexcept {
  const Signals& now = trainer_.signals();
  const double reference_ml = trainer_.circulation().parameters().reference_volume_ml;
  const double natural_cm2 =
      shortening_area_cm2(natural_.circulation().last_beat().contracting_ml, reference_ml);
  const double now_cm2 = shortening_area_cm2(now.beat.contracting_ml, reference_ml);
  const Answer answer{.pressure_n_per_m = palpation::pressure_n_per_m(trainer_.circulation()),
                      .wall_m = now.wall_m - natural_.signals().wall_m,
                      .shortening_ratio = natural_cm2 > 0 ? now_cm2 / natural_cm2 : 1,
                      .given_m = now.given_m};
  answer_.write(answer);
}

bool CommonCirculation::latest(Signals& signals) const noexcept { return trainer_.latest(signals); }

void CommonCirculation::wish(const PalpationParameters& parameters) {
  natural_.wish(parameters);
  trainer_.wish(parameters);
}

}  // namespace beatlas::palpation
