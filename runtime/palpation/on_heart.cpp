#include "runtime/palpation/on_heart.h"

#include <array>

#include "runtime/palpation/fit.h"

namespace beatlas::palpation {
namespace {

using C = CirculationParameters;
// What goes with the size of a heart; pressures, contractility and the finger do not.
constexpr std::array kOfSize{&C::weight_kg,    &C::resistance,      &C::impedance, &C::compliance,
                             &C::aortic_valve, &C::mitral_valve,    &C::emax,      &C::emin,
                             &C::v0_ml,        &C::contact_area_cm2};

}  // namespace

PalpationParameters on_heart(const PalpationParameters& told, const HeartSize& heart) {
  const C healthy = PalpationParameters{}.whole_circulation();
  const C fitted = fit_to_heart(healthy, heart.edv_ml, heart.esv_ml, heart.heart_rate_per_min);
  PalpationParameters out = told;
  for (const auto number : kOfSize) {
    out.circulation.*number *= fitted.*number / healthy.*number;
  }
  out.circulation.heart_rate_per_min = fitted.heart_rate_per_min;
  // What was the dog's may be less than this heart holds without a pressure; its own is found now.
  if (out.circulation.reference_volume_ml < out.circulation.v0_ml) {
    out.circulation.reference_volume_ml = fitted.reference_volume_ml;
  }
  out.circulation.reference_volume_ml = natural_beat(out.whole_circulation()).edv_ml;
  out.check();
  return out;
}

}  // namespace beatlas::palpation
