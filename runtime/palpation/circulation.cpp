#include "runtime/palpation/circulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "runtime/base/error.h"
#include "runtime/palpation/units.h"

namespace beatlas::palpation {
namespace {

const double kGamma = 1 - std::sqrt(0.5);  // Alexander's L-stable two-stage method
constexpr int kMostIterations = 100;
constexpr int kFinestParts = 32;  // of a tick
// What may happen in one part, for a ventricle of 1 ml: change of flow times its length, change of
// the finger's force times its way.
constexpr double kMostBend = 1e-3;   // [ml]
constexpr double kMostBlowJ = 2e-7;  // [J]
constexpr double kNoFingerM = -1;

void require(double value, double low, double high, const char* name) {
  if (value >= low && value <= high) return;
  std::ostringstream text;
  text << "the circulation's " << name << " must be from " << low << " to " << high;
  throw_invalid(text.str());
}

}  // namespace

double CirculationParameters::effective_emax() const noexcept {
  const double healthy = std::max(emin, contractility * emax);
  return emin + (healthy - emin) * (1 - infarct_fraction * (1 - infarct_alpha));
}

void CirculationParameters::check() const {
  require(weight_kg, 1, 500, "weight_kg");
  require(heart_rate_per_min, kSlowestPerMin, kQuickestPerMin, "heart_rate_per_min");
  require(left_atrial_mmhg, 0, 40, "left_atrial_mmhg");
  require(right_atrial_mmhg, 0, 40, "right_atrial_mmhg");
  require(resistance, 1e-3, 1e3, "resistance");
  require(impedance, 1e-4, 1e2, "impedance");
  require(compliance, 1e-3, 1e2, "compliance");
  require(aortic_valve, 1e-4, 1, "aortic_valve");
  require(mitral_valve, 1e-4, 1, "mitral_valve");
  require(emin, 1e-4, 1e2, "emin");
  require(emax, emin, 1e3, "emax");
  require(branch_elastance, 0, 1e3, "branch_elastance");
  require(v0_ml, 0, 1e3, "v0_ml");
  require(relaxation_rate_per_s, 1, 1e3, "relaxation_rate_per_s");
  require(contractility, 0.1, 3, "contractility");
  require(infarct_fraction, 0, 1, "infarct_fraction");
  require(infarct_alpha, 0, 1, "infarct_alpha");
  require(contact_area_cm2, 0.1, 1e3, "contact_area_cm2");
  require(stop_n_per_m, 1, 1e6, "stop_n_per_m");
  require(finger_k_n_per_m, 0, 1e5, "finger_k_n_per_m");
  require(finger_c_n_s_per_m, 1e-3, 1e5, "finger_c_n_s_per_m");
  require(reference_volume_ml, v0_ml, 1e4, "reference_volume_ml");
}

CirculationParameters at_weight(const CirculationParameters& parameters,
                                double weight_kg) noexcept {
  CirculationParameters out = parameters;
  const double ratio = weight_kg / parameters.weight_kg;
  if (ratio == 1) return out;
  const double root = std::sqrt(ratio);
  const double slower = 1 / (root * std::sqrt(root));  // ratio^-3/4
  out.weight_kg = weight_kg;
  out.resistance *= slower;
  out.impedance *= slower;
  out.aortic_valve *= slower;
  out.mitral_valve *= slower;
  out.compliance *= ratio;
  out.v0_ml *= ratio;
  out.reference_volume_ml *= ratio;
  out.emax /= ratio;
  out.emin /= ratio;
  out.branch_elastance /= ratio;
  const double length = std::cbrt(ratio);
  out.contact_area_cm2 *= length * length;
  return out;
}

// One stage of a step, solved.
struct Circulation::Stage {
  State state;
  double elastance;
  double activation;
  double active;       // of the contractile element [mmHg/ml]
  double active_rate;  // mmHg/ml/s
  double letting_go;   // p after contraction [mmHg]
  double depth_m;
  double finger_n;
  double dent_rate;  // m/s
  double lv_mmhg;
  double mitral;
  double aortic;
};

Circulation::Circulation(const CirculationParameters& parameters)
    : p_(parameters), curve_(60 / parameters.heart_rate_per_min, parameters.relaxation_rate_per_s) {
  p_.check();
  derive();
  now_ = {p_.reference_volume_ml, 90, 0, 0};
  elastance_ = p_.emin;
  depth_m_ = kNoFingerM;
  running_.esv_ml = running_.aortic_low_mmhg = INFINITY;
  ledger_.stored_at_start_j = ledger_.stored_j = stored_j();
}

void Circulation::derive() noexcept {
  d_.span = p_.effective_emax() - p_.emin;
  d_.out = p_.aortic_valve + p_.impedance;
  d_.x_per_ml = kM3PerMl / (kM2PerCm2 * p_.contact_area_cm2);
  d_.mmhg_per_n = 1 / (kM2PerCm2 * p_.contact_area_cm2 * kPaPerMmhg);
}

void Circulation::adjust(const CirculationParameters& parameters) noexcept {
  const double before_j = stored_j();
  p_ = parameters;
  derive();
  elastance_ = p_.emin + d_.span * activation_;
  if (contracting_) active_ = d_.span * activation_;
  const double changed_j = stored_j() - before_j;
  ledger_.muscle_j += changed_j;
  ledger_.stored_j += changed_j;
  ledger_.turned_over_j += std::abs(changed_j);
}

Circulation::Stage Circulation::solve(const State& base, double time_s, double gamma_s,
                                      double depth_m, double guess_ml) const noexcept {
  Stage s{};
  const double period_s = curve_.period_s();
  const bool next_beat = time_s >= period_s;
  const auto e = curve_.at(next_beat ? time_s - period_s : time_s);
  s.activation = e.value;
  s.elastance = p_.emin + d_.span * e.value;
  if (contracting_ || next_beat) {
    s.active = d_.span * e.value;
    s.active_rate = d_.span * e.slope_per_s;
  }
  s.letting_go = letting_go_ * std::exp(-p_.relaxation_rate_per_s * (time_s - beat_s_));
  s.depth_m = depth_m;
  // The branch: q = died + stiff (V - base).
  const double damped = 1 + gamma_s * p_.relaxation_rate_per_s;
  const double died = base.branch / damped;
  const double stiff = contracting_ ? 0 : p_.branch_elastance / damped;

  // The vessel: P_c = at_rest + rise Q.
  const double leak = gamma_s / (p_.resistance * p_.compliance);
  const double at_rest = (base.vessel + leak * p_.right_atrial_mmhg) / (1 + leak);
  const double rise = gamma_s / p_.compliance / (1 + leak);
  // The finger: dent = recovered + give F, and F = firmness (D + x1 - recovered), if positive.
  double recovered = 0;
  double give = 0;
  if (p_.contact == Contact::Viscoelastic) {
    const double slowed = p_.finger_c_n_s_per_m + gamma_s * p_.finger_k_n_per_m;
    recovered = p_.finger_c_n_s_per_m * base.dent / slowed;
    give = gamma_s / slowed;
  }
  const double firmness = p_.stop_n_per_m / (1 + p_.stop_n_per_m * give);

  // V = base + gamma (mitral - aortic): all flows fall as V rises, so there is one root.
  double low = -INFINITY;
  double high = INFINITY;
  double volume = guess_ml;
  for (int i = 0; i < kMostIterations; ++i) {
    const double pressed_m = depth_m + d_.x_per_ml * (volume - p_.reference_volume_ml) - recovered;
    const double passing = letting_go(volume, s.letting_go);
    double slope = p_.emin + s.active + stiff;
    if (passing < s.letting_go) slope += s.letting_go / std::max(let_go_ml_, kLeastMl);
    s.state.branch = died + stiff * (volume - base.volume);
    s.finger_n = 0;
    if (pressed_m > 0) {
      s.finger_n = firmness * pressed_m;
      slope += firmness * d_.x_per_ml * d_.mmhg_per_n;
    }
    s.lv_mmhg = (p_.emin + s.active) * (volume - p_.v0_ml) + s.state.branch + passing +
                s.finger_n * d_.mmhg_per_n;
    double steepness = 1;
    s.mitral = 0;
    s.aortic = 0;
    if (s.lv_mmhg < p_.left_atrial_mmhg) {
      s.mitral = (p_.left_atrial_mmhg - s.lv_mmhg) / p_.mitral_valve;
      steepness += gamma_s * slope / p_.mitral_valve;
    }
    if (s.lv_mmhg > at_rest) {
      s.aortic = (s.lv_mmhg - at_rest) / (d_.out + rise);
      steepness += gamma_s * slope / (d_.out + rise);
    }
    const double residual = volume - base.volume - gamma_s * (s.mitral - s.aortic);
    if (std::abs(residual) <= 1e-13 * (std::abs(volume) + 1) * steepness) break;
    (residual > 0 ? high : low) = volume;
    volume -= residual / steepness;
    if (!(volume > low && volume < high)) volume = 0.5 * (low + high);
  }
  s.state.branch = died + stiff * (volume - base.volume);
  s.state.volume = volume;
  s.state.vessel = at_rest + rise * s.aortic;
  s.state.dent = recovered + give * s.finger_n;
  s.dent_rate = (s.state.dent - base.dent) / gamma_s;
  return s;
}

void Circulation::account(const Stage& s, double share_s, double depth_rate_m_s) noexcept {
  const double unstressed = s.state.volume - p_.v0_ml;
  const double leak = (s.state.vessel - p_.right_atrial_mmhg) / p_.resistance;
  // What lets go, and the branch while nothing drives it, take up work and keep none of it.
  const double kept_not =
      letting_go(s.state.volume, s.letting_go) + (contracting_ ? s.state.branch : 0);
  const double muscle =
      (0.5 * s.active_rate * unstressed * unstressed - kept_not * (s.mitral - s.aortic)) *
      kJPerMmhgMl * share_s;
  const double in = p_.left_atrial_mmhg * s.mitral * kJPerMmhgMl * share_s;
  const double out = p_.right_atrial_mmhg * leak * kJPerMmhgMl * share_s;
  const double finger = s.finger_n * depth_rate_m_s * share_s;
  double lost = (p_.mitral_valve * s.mitral * s.mitral + d_.out * s.aortic * s.aortic +
                 p_.resistance * leak * leak) *
                kJPerMmhgMl * share_s;
  if (p_.branch_elastance > 0) {
    lost += p_.relaxation_rate_per_s * s.state.branch * s.state.branch / p_.branch_elastance *
            kJPerMmhgMl * share_s;
  }
  if (p_.contact == Contact::Viscoelastic) {
    lost += p_.finger_c_n_s_per_m * s.dent_rate * s.dent_rate * share_s;
  }
  ledger_.muscle_j += muscle;
  ledger_.atria_j += in - out;
  ledger_.finger_j += finger;
  ledger_.dissipated_j += lost;
  ledger_.turned_over_j += std::abs(muscle) + in + std::abs(out) + std::abs(finger) + lost;
}

double Circulation::stored_j() const noexcept {
  const double unstressed = now_.volume - p_.v0_ml;
  double out =
      0.5 * kJPerMmhgMl *
      ((p_.emin + active_) * unstressed * unstressed + p_.compliance * now_.vessel * now_.vessel);
  if (p_.branch_elastance > 0) {
    out += 0.5 * kJPerMmhgMl * now_.branch * now_.branch / p_.branch_elastance;
  }
  const double squeezed = finger_n_ / p_.stop_n_per_m;
  out += 0.5 * p_.stop_n_per_m * squeezed * squeezed;
  if (p_.contact == Contact::Viscoelastic) {
    out += 0.5 * p_.finger_k_n_per_m * now_.dent * now_.dent;
  }
  return out;
}

// A part of a tick. False, and nothing is changed, if that is too coarse for what happens in it.
bool Circulation::part(double step_s, double depth_rate, Care care, double& flowed) noexcept {
  const double gamma_s = care == Care::BackwardEuler ? step_s : kGamma * step_s;
  const Stage first =
      solve(now_, beat_s_ + gamma_s, gamma_s, depth_m_ + depth_rate * gamma_s, now_.volume);
  if (care == Care::BackwardEuler) {
    account(first, step_s, depth_rate);
    flowed += step_s * first.aortic;
    accept(first, step_s);
    return true;
  }
  const auto carried = [](double from, double at) {
    return from + (1 - kGamma) / kGamma * (at - from);
  };
  const State base{carried(now_.volume, first.state.volume),
                   carried(now_.vessel, first.state.vessel), carried(now_.dent, first.state.dent),
                   carried(now_.branch, first.state.branch)};
  const Stage last =
      solve(base, beat_s_ + step_s, gamma_s, depth_m_ + depth_rate * step_s, first.state.volume);
  // The method's stages may overshoot where all comes to rest within a step.
  if (last.state.vessel < 0 || last.state.volume < std::min(p_.v0_ml, now_.volume)) return false;
  if (care == Care::Accurate) {
    const double flow = last.mitral - last.aortic;
    const double bend_ml = step_s * std::max(std::abs(flow - (first.mitral - first.aortic)),
                                             std::abs(flow - (mitral_ - aortic_)));
    const double blow_j = step_s * std::abs(depth_rate * (last.finger_n - finger_n_));
    const double size = p_.reference_volume_ml;
    if (!(bend_ml <= kMostBend * size) || !(blow_j <= kMostBlowJ * size)) return false;
  }
  account(first, step_s - gamma_s, depth_rate);
  account(last, gamma_s, depth_rate);
  flowed += (step_s - gamma_s) * first.aortic + gamma_s * last.aortic;
  accept(last, step_s);
  return true;
}

void Circulation::accept(const Stage& stage, double step_s) noexcept {
  now_ = stage.state;
  depth_m_ = stage.depth_m;
  lv_mmhg_ = stage.lv_mmhg;
  mitral_ = stage.mitral;
  aortic_ = stage.aortic;
  finger_n_ = stage.finger_n;
  elastance_ = stage.elastance;
  activation_ = stage.activation;
  active_ = stage.active;
  letting_go_ = stage.letting_go;
  beat_s_ += step_s;
}

// Mostly one part; more where a valve or the finger gives a blow.
void Circulation::advance(double step_s, double depth_rate, double& flowed_ml) noexcept {
  int parts_left = kFinestParts;
  int parts = kFinestParts;  // of the next try
  while (parts_left > 0) {
    parts = std::min(parts, parts_left);
    const double part_s = step_s * parts / kFinestParts;
    if (part(part_s, depth_rate, parts > 1 ? Care::Accurate : Care::Sound, flowed_ml)) {
      parts_left -= parts;
      parts *= 2;
    } else if (parts > 1) {
      parts /= 2;
    } else {
      (void)part(part_s, depth_rate, Care::BackwardEuler, flowed_ml);
      --parts_left;
    }
  }
}

void Circulation::let_go() noexcept {
  const double unstressed = now_.volume - p_.v0_ml;
  const double held_j = 0.5 * active_ * unstressed * unstressed * kJPerMmhgMl;
  letting_go_ += active_ * unstressed;
  let_go_ml_ = unstressed;
  active_ = 0;
  contracting_ = false;
  ledger_.muscle_j -= held_j;
  ledger_.turned_over_j += held_j;
}

void Circulation::tick(double step_s, double depth_m) noexcept {
  if (!(step_s > 0 && step_s < curve_.period_s())) return;
  const double deepest_m = d_.x_per_ml * (p_.reference_volume_ml - p_.v0_ml);
  if (!(depth_m >= -1)) depth_m = kNoFingerM;
  depth_m = std::min(depth_m, deepest_m);
  const double rate = (depth_m - depth_m_) / step_s;
  const double lv_before = lv_mmhg_;
  double flowed_ml = 0;
  // The muscle lets go at a moment of its own, not at a tick's.
  const double until_s = curve_.relaxes_from_s() - beat_s_;
  const bool lets_go = contracting_ && until_s <= step_s;
  if (lets_go) {
    if (until_s > 0) advance(until_s, rate, flowed_ml);
    let_go();
  }
  const double rest_s = lets_go ? step_s - std::max(until_s, 0.0) : step_s;
  if (rest_s > 0) advance(rest_s, rate, flowed_ml);
  depth_m_ = depth_m;
  ledger_.stored_j = stored_j();
  follow_beat(step_s, flowed_ml, lv_before);
}

void Circulation::follow_beat(double step_s, double flowed_ml, double lv_before) noexcept {
  const double aorta = aortic_mmhg();
  running_.edv_ml = std::max(running_.edv_ml, now_.volume);
  running_.esv_ml = std::min(running_.esv_ml, now_.volume);
  running_.stroke_ml += flowed_ml;
  running_.peak_lv_mmhg = std::max(running_.peak_lv_mmhg, lv_mmhg_);
  running_.aortic_high_mmhg = std::max(running_.aortic_high_mmhg, aorta);
  running_.aortic_low_mmhg = std::min(running_.aortic_low_mmhg, aorta);
  running_.dpdt_max_mmhg_per_s =
      std::max(running_.dpdt_max_mmhg_per_s, (lv_mmhg_ - lv_before) / step_s);
  running_mean_ += step_s * aorta;
  running_s_ += step_s;
  if (contracting_) {
    contracting_ml_s_ += step_s * now_.volume;
    contracting_s_ += step_s;
  }
  // Half a rounding error early is not late.
  if (beat_s_ >= curve_.period_s() * (1 - 1e-12)) end_beat();
}

void Circulation::end_beat() noexcept {
  last_ = running_;
  last_.aortic_mean_mmhg = running_mean_ / running_s_;
  last_.ejection_fraction = last_.edv_ml > 0 ? (last_.edv_ml - last_.esv_ml) / last_.edv_ml : 0;
  last_.output_l_per_min = last_.stroke_ml * 60 / curve_.period_s() / 1000;
  running_ = Beat{};
  running_.esv_ml = running_.aortic_low_mmhg = INFINITY;
  if (contracting_s_ > 0) last_.contracting_ml = contracting_ml_s_ / contracting_s_;
  running_mean_ = running_s_ = contracting_ml_s_ = contracting_s_ = 0;
  contracting_ = true;
  ++beats_;
  beat_s_ = std::max(0.0, beat_s_ - curve_.period_s());
  const double period_s = 60 / p_.heart_rate_per_min;
  if (period_s != curve_.period_s() || p_.relaxation_rate_per_s != curve_.rate_per_s()) {
    curve_ = ElastanceCurve(period_s, p_.relaxation_rate_per_s);
    beat_s_ = std::min(beat_s_, 0.5 * period_s);
  }
}

void Circulation::settle(double step_s) noexcept {
  constexpr long kMostBeats = 400;
  const long until = beats_ + kMostBeats;
  double before = -1;
  while (beats_ < until) {
    const long beat = beats_;
    const double step = curve_.period_s() / std::ceil(curve_.period_s() / step_s);
    while (beats_ == beat) tick(step, kNoFingerM);
    if (std::abs(last_.stroke_ml - before) <= 1e-9 * last_.stroke_ml) return;
    before = last_.stroke_ml;
  }
}

}  // namespace beatlas::palpation
