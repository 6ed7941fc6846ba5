#include "runtime/palpation/trainer.h"

#include <algorithm>
#include <cmath>

#include "runtime/base/error.h"
#include "runtime/palpation/fit.h"
#include "runtime/palpation/units.h"

namespace beatlas::palpation {
namespace {

constexpr double kGlideS = 0.25;
constexpr double kDeepestM = 0.03;
constexpr double kLargestDentShare = 0.8;  // of the ventricle's side
constexpr double kCm3PerMl = 1;

using C = CirculationParameters;
// What glides. The heart rate waits for the beat, the finger's contact is what it is.
constexpr std::array kGlides{&C::left_atrial_mmhg,
                             &C::right_atrial_mmhg,
                             &C::resistance,
                             &C::impedance,
                             &C::compliance,
                             &C::aortic_valve,
                             &C::mitral_valve,
                             &C::emax,
                             &C::emin,
                             &C::branch_elastance,
                             &C::v0_ml,
                             &C::contractility,
                             &C::infarct_fraction,
                             &C::infarct_alpha,
                             &C::relaxation_rate_per_s,
                             &C::contact_area_cm2,
                             &C::stop_n_per_m,
                             &C::finger_k_n_per_m,
                             &C::finger_c_n_s_per_m,
                             &C::reference_volume_ml};

}  // namespace

Trainer::Trainer(const PalpationParameters& parameters, std::size_t fingers)
    : parameters_(parameters),
      target_(parameters.whole_circulation()),
      circulation_(target_),
      count_(fingers) {
  parameters.check();
  if (fingers < 1 || fingers > kMostFingers) throw_invalid("a trainer must have 1 to 8 fingers");
  for (std::size_t n = 0; n < count_; ++n) {
    const MuscleConstants& middle = parameters.muscle.middle;
    touches_[n] = std::make_unique<Touch>(
        Touch{.patch = VerticalPatch({.mass_kg = parameters.wall_mass_kg,
                                      .damping_n_s_per_m = middle.c_v_n_s_per_m,
                                      .contact_n_per_m = parameters.contact_n_per_m}),
              .horizontal =
                  HorizontalMuscle(middle.k_h1_n_per_m, middle.k_h2_n_per_m, middle.c_h_n_s_per_m),
              .muscle = middle});
  }
  circulation_.settle();
  side_area_cm2_ = cylinder_of(target_.reference_volume_ml).side_area_cm2();
  dents_.set_radius_mm(dent_radius_mm(target_.contact_area_cm2));
  signals_.natural_output_l_per_min = circulation_.last_beat().output_l_per_min;
  signals_.fingers = static_cast<std::uint32_t>(count_);
}

void Trainer::wish(const PalpationParameters& parameters) {
  parameters.check();
  wishes_.offer(std::make_unique<PalpationParameters>(parameters));
}

void Trainer::take_up_wish() noexcept {
  if (!wishes_.take_up(wished_)) return;
  parameters_ = *wished_;
  target_ = parameters_.whole_circulation();
  if (!(parameters_.aortic_target_mmhg > 0)) resistance_factor_ = 1;
  gliding_ = true;
  for (std::size_t n = 0; n < count_; ++n) touches_[n]->segment = -1;  // look it up anew
}

void Trainer::glide(double step_s) noexcept {
  if (!gliding_) return;
  CirculationParameters now = circulation_.parameters();
  CirculationParameters target = target_;
  target.resistance *= resistance_factor_;
  const double share = -std::expm1(-step_s / kGlideS);
  bool there = true;
  for (const auto member : kGlides) {
    const double way = target.*member - now.*member;
    if (std::abs(way) <= 1e-9 * std::abs(target.*member)) {
      now.*member = target.*member;
    } else {
      now.*member += share * way;
      there = false;
    }
  }
  now.contact = target.contact;
  now.weight_kg = target.weight_kg;
  now.heart_rate_per_min = target.heart_rate_per_min;
  circulation_.adjust(now);
  side_area_cm2_ = cylinder_of(now.reference_volume_ml).side_area_cm2();
  dents_.set_radius_mm(dent_radius_mm(now.contact_area_cm2));
  gliding_ = !there;
}

// A beat has ended: the resistance goes half of the way to what would give the wished pressure.
void Trainer::hold_aortic_pressure() noexcept {
  if (!(parameters_.aortic_target_mmhg > 0)) return;
  const double right = target_.right_atrial_mmhg;
  const double mean = circulation_.last_beat().aortic_mean_mmhg;
  if (!(mean > right + 1)) return;
  const double ratio = std::sqrt((parameters_.aortic_target_mmhg - right) / (mean - right));
  resistance_factor_ = std::clamp(resistance_factor_ * std::clamp(ratio, 0.8, 1.25), 0.05, 20.0);
  gliding_ = true;
}

void Trainer::place(Touch& touch, const Finger& finger) noexcept {
  touch.place_mm = finger.place_mm;
  const double long_axis = std::isfinite(finger.long_axis) ? finger.long_axis : 0.5;
  if (long_axis == touch.long_axis && finger.segment == touch.segment &&
      finger.tissue == touch.tissue) {
    return;
  }
  touch.long_axis = long_axis;
  touch.segment = finger.segment;
  touch.tissue = finger.tissue;
  const bool known = finger.segment >= 1 && finger.segment <= kSegments;
  const Tissue tissue = finger.tissue ? *finger.tissue
                        : known ? parameters_.segments[static_cast<std::size_t>(finger.segment - 1)]
                                : Tissue{};
  touch.muscle = parameters_.at(long_axis, tissue);
  touch.alpha = tissue.alpha;
  touch.patch.set_damping(touch.muscle.c_v_n_s_per_m);
  touch.horizontal.set(touch.muscle.k_h1_n_per_m, touch.muscle.k_h2_n_per_m,
                       touch.muscle.c_h_n_s_per_m);
}

// Equation (1) with the dents' volume; outward, 0 at end-diastole.
double Trainer::wall_m(double whole_dent_m) const noexcept {
  const CirculationParameters& p = circulation_.parameters();
  const double out_cm =
      (circulation_.volume_ml() - p.reference_volume_ml) * kCm3PerMl / side_area_cm2_;
  const double share = std::min(p.contact_area_cm2 / side_area_cm2_, kLargestDentShare);
  const double out_m = 0.01 * out_cm;
  // The dent is D + x_wall deep: where that is nothing, the wall is the cylinder's.
  if (!(whole_dent_m + out_m > 0)) return out_m;
  return (out_m + share * whole_dent_m) / (1 - share);
}

std::span<const double> Trainer::tick(double step_s, std::span<const Finger> fingers) noexcept {
  const std::span<const double> answer = std::span(forces_).first(count_);
  if (!(step_s > 0 && step_s < 0.2)) return answer;
  take_up_wish();
  glide(step_s);

  std::array<DentSource, kMostFingers> sources;
  double deepest_m = -1;
  for (std::size_t n = 0; n < count_; ++n) {
    const Finger finger = n < fingers.size() ? fingers[n] : Finger{};
    place(*touches_[n], finger);
    const double depth_m = finger.depth_m >= -1 ? std::min(finger.depth_m, kDeepestM) : -1;
    sources[n] = {finger.place_mm, kMmPerM * depth_m};
    deepest_m = std::max(deepest_m, depth_m);
  }
  double whole_m = deepest_m;
  if (deepest_m > 0 && count_ > 1) {
    dents_.set(std::span(sources).first(count_));
    whole_m = dents_.whole_depth_mm() / kMmPerM;
  }
  const long beat = circulation_.beats();
  circulation_.tick(step_s, whole_m);
  if (circulation_.beats() != beat) hold_aortic_pressure();

  const double wall = wall_m(whole_m);
  const double elastance = circulation_.elastance_mmhg_per_ml();
  const double pressure = pressure_n_per_m(circulation_);
  std::array<double, kMostFingers> given{};  // by the dents of the others, as of the tick before
  for (std::size_t n = 0; n < count_; ++n) {
    for (std::size_t other = 0; other < count_; ++other) {
      if (other == n) continue;
      given[n] += touches_[other]->patch.dent_m() *
                  dents_.weight(touches_[n]->place_mm, touches_[other]->place_mm);
    }
  }
  for (std::size_t n = 0; n < count_; ++n) {
    Touch& touch = *touches_[n];
    const double depth_m = sources[n].depth_mm / kMmPerM + wall;
    const double contractile = contractile_n_per_m(parameters_, touch.alpha, circulation_);
    forces_[n] = touch.patch.advance(depth_m - given[n],
                                     touch.muscle.k_v_n_per_m + contractile + pressure, step_s);
    signals_.muscle_n[n] = circulation_.contracting() ? touch.horizontal.contract(wall, contractile)
                                                      : touch.horizontal.relax(wall, step_s);
    signals_.force_n[n] = forces_[n];
    signals_.depth_m[n] = depth_m;
    signals_.given_m[n] = given[n];
    signals_.dent_m[n] = touch.patch.touching() ? depth_m : touch.patch.dent_m() + given[n];
  }

  signals_.time_s += step_s;
  ++signals_.ticks;
  signals_.phase = circulation_.phase();
  signals_.heart_rate_per_min = circulation_.parameters().heart_rate_per_min;
  signals_.volume_ml = circulation_.volume_ml();
  signals_.lv_mmhg = circulation_.lv_mmhg();
  signals_.aortic_mmhg = circulation_.aortic_mmhg();
  signals_.left_atrial_mmhg = circulation_.parameters().left_atrial_mmhg;
  signals_.mitral_flow_ml_s = circulation_.mitral_flow_ml_s();
  signals_.aortic_flow_ml_s = circulation_.aortic_flow_ml_s();
  signals_.elastance_mmhg_per_ml = elastance;
  signals_.wall_m = wall;
  signals_.beat = circulation_.last_beat();
  signals_.beats = static_cast<std::uint64_t>(circulation_.beats());
  published_.write(signals_);
  return answer;
}

}  // namespace beatlas::palpation
