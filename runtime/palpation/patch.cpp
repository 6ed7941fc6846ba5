#include "runtime/palpation/patch.h"

#include <algorithm>
#include <cmath>

#include "runtime/base/error.h"

namespace beatlas::palpation {
namespace {

constexpr int kMostSwitches = 8;  // finger and wall meet or part, within one step
constexpr int kHalvings = 60;

void check(double mass_kg, double damping) {
  if (!(mass_kg >= 0 && mass_kg <= 10)) throw_invalid("a patch's mass must be from 0 to 10 kg");
  if (!(damping >= 0 && damping <= 1e5)) {
    throw_invalid("a patch's damping must be from 0 to 1e5 N s/m");
  }
  if (mass_kg == 0 && damping == 0) throw_invalid("a patch must have a mass or a damper");
}

}  // namespace

struct VerticalPatch::Line {
  double depth_m;
  double speed_m_s;
};

VerticalPatch::VerticalPatch(const VerticalConstants& constants)
    : mass_kg_(constants.mass_kg),
      printed_damping_(constants.damping_n_s_per_m),
      contact_(constants.contact_n_per_m) {
  check(mass_kg_, printed_damping_);
  if (!(contact_ >= 1 && contact_ <= 1e6)) {
    throw_invalid("a patch's contact spring must be from 1 to 1e6 N/m");
  }
  set_stiffness(0);
}

void VerticalPatch::set_stiffness(double stiffness) noexcept {
  if (!(stiffness >= 0)) stiffness = 0;
  stiffness = std::min(stiffness, kStiffestShare * contact_);
  if (stiffness == stiffness_) return;
  stiffness_ = stiffness;
  derive();
}

void VerticalPatch::set_damping(double damping_n_s_per_m) noexcept {
  if (!(damping_n_s_per_m > 0) || damping_n_s_per_m == printed_damping_) return;
  printed_damping_ = damping_n_s_per_m;
  derive();
}

void VerticalPatch::derive() noexcept {
  const double softer = contact_ / (contact_ - stiffness_);  // K_s / K, 1 for no stiffness
  spring_ = stiffness_ * softer;
  damping_ = printed_damping_ * softer;
  kept_step_s_[0] = kept_step_s_[1] = -1;
}

OscillatorStep VerticalPatch::step_of(double step_s) noexcept {
  const int which = touching_ ? 1 : 0;
  if (kept_step_s_[which] != step_s) {
    kept_[which] =
        OscillatorStep({mass_kg_, damping_, spring_ + (touching_ ? contact_ : 0)}, step_s);
    kept_step_s_[which] = step_s;
  }
  return kept_[which];
}

Motion VerticalPatch::moved(const Line& line, double step_s) noexcept {
  const double push = touching_ ? contact_ : 0;
  return step_of(step_s).advance(wall_, push * line.depth_m, push * line.speed_m_s);
}

double VerticalPatch::gap_m(const Line& line, double step_s) noexcept {
  return line.depth_m + line.speed_m_s * step_s - moved(line, step_s).place_m;
}

// Whether the gap between finger and wall changes its sign in (0, step_s], and where.
bool VerticalPatch::parts_within(const Line& line, double step_s, double& at_s) noexcept {
  const double sign = touching_ ? 1 : -1;  // the gap, d - y, is positive in contact
  double outside = step_s;
  if (sign * gap_m(line, step_s) >= 0) {
    // It may have been beyond in between: look at its turning point.
    const auto closing = [&](double t) {
      return sign * (line.speed_m_s - moved(line, t).speed_m_s);
    };
    if (sign * (line.speed_m_s - wall_.speed_m_s) >= 0 || closing(step_s) <= 0) return false;
    double before = 0;
    double after = step_s;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (before + after);
      (closing(middle) < 0 ? before : after) = middle;
    }
    if (sign * gap_m(line, after) >= 0) return false;
    outside = after;
  }
  double inside = 0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    (sign * gap_m(line, middle) >= 0 ? inside : outside) = middle;
  }
  at_s = outside;
  return true;
}

double VerticalPatch::advance(double depth_m, double stiffness_n_per_m, double step_s) noexcept {
  set_stiffness(stiffness_n_per_m);
  if (!(step_s > 0) || !std::isfinite(step_s) || !std::isfinite(depth_m)) return force_n();
  Line line{depth_m_, (depth_m - depth_m_) / step_s};
  double left_s = step_s;
  for (int switches = 0; left_s > 0; ++switches) {
    double at_s = left_s;
    const bool parts = switches < kMostSwitches && parts_within(line, left_s, at_s);
    const Motion next = moved(line, at_s);
    wall_ = next;
    line.depth_m += line.speed_m_s * at_s;
    left_s -= at_s;
    if (!parts) break;
    touching_ = !touching_;
  }
  depth_m_ = depth_m;
  return force_n();
}

double VerticalPatch::force_n() const noexcept {
  return touching_ ? std::max(0.0, contact_ * (depth_m_ - wall_.place_m)) : 0;
}

double VerticalPatch::energy_j() const noexcept {
  const double squeezed = force_n() / contact_;
  return 0.5 * (mass_kg_ * wall_.speed_m_s * wall_.speed_m_s +
                spring_ * wall_.place_m * wall_.place_m + contact_ * squeezed * squeezed);
}

VerticalPatch::State VerticalPatch::state() const noexcept {
  return {wall_, depth_m_, stiffness_, touching_};
}

void VerticalPatch::restore(const State& state) noexcept {
  set_stiffness(state.stiffness_n_per_m);
  wall_ = state.wall;
  depth_m_ = state.depth_m;
  touching_ = state.touching;
}

KelvinVoigtPatch::KelvinVoigtPatch(double mass_kg, double damping_n_s_per_m,
                                   double stiffness_n_per_m)
    : oscillator_{mass_kg, damping_n_s_per_m, stiffness_n_per_m} {
  check(mass_kg, damping_n_s_per_m);
  if (!(stiffness_n_per_m >= 0 && stiffness_n_per_m <= 1e6)) {
    throw_invalid("a patch's stiffness must be from 0 to 1e6 N/m");
  }
}

double KelvinVoigtPatch::push(double force_n, double step_s) noexcept {
  if (step_s > 0) {
    if (kept_step_s_ != step_s) {
      kept_ = OscillatorStep(oscillator_, step_s);
      kept_step_s_ = step_s;
    }
    wall_ = kept_.advance(wall_, force_n_, (force_n - force_n_) / step_s);
  }
  force_n_ = force_n;
  return wall_.place_m;
}

double KelvinVoigtPatch::energy_j() const noexcept {
  return 0.5 * (oscillator_.mass_kg * wall_.speed_m_s * wall_.speed_m_s +
                oscillator_.stiffness_n_per_m * wall_.place_m * wall_.place_m);
}

double KelvinVoigtPatch::reaction_n(double dent_m, double speed_m_s,
                                    double acceleration_m_s2) const noexcept {
  return std::max(0.0, oscillator_.mass_kg * acceleration_m_s2 +
                           oscillator_.damping_n_s_per_m * speed_m_s +
                           oscillator_.stiffness_n_per_m * dent_m);
}

}  // namespace beatlas::palpation
