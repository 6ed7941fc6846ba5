#include "runtime/palpation/fit.h"

#include <algorithm>
#include <cmath>

#include "runtime/base/error.h"

namespace beatlas::palpation {
namespace {

constexpr double kClose = 1e-3;
constexpr int kMostRounds = 200;

double off(double value, double target) { return target > 0 ? value / target - 1 : 0; }

}  // namespace

Beat natural_beat(const CirculationParameters& parameters) {
  Circulation circulation(parameters);
  circulation.settle();
  return circulation.last_beat();
}

CirculationParameters fit_circulation(const CirculationParameters& start, const Targets& targets) {
  const auto sound = [](double value, double most) { return value >= 0 && value <= most; };
  if (!sound(targets.edv_ml, 1000) || !sound(targets.esv_ml, 1000) ||
      (targets.esv_ml > 0 && targets.edv_ml > 0 && targets.esv_ml >= 0.98 * targets.edv_ml)) {
    throw_invalid("volumes to fit must be from 0 to 1000 ml, the end-systolic one the smaller");
  }
  if (!sound(targets.aortic_mean_mmhg, 250) ||
      (targets.aortic_mean_mmhg > 0 && targets.aortic_mean_mmhg <= start.right_atrial_mmhg + 1)) {
    throw_invalid("the mean aortic pressure to fit must be above the right atrium's, to 250 mmHg");
  }
  start.check();
  CirculationParameters fit = start;
  // A circulation is fitted in small steps of the logarithm: what raises one raises or lowers the
  // others by less than its own.
  for (int round = 0; round < kMostRounds; ++round) {
    const Beat beat = natural_beat(fit);
    const double off_edv = off(beat.edv_ml, targets.edv_ml);
    const double off_esv = off(beat.esv_ml, targets.esv_ml);
    const double off_mean = off(beat.aortic_mean_mmhg, targets.aortic_mean_mmhg);
    if (std::max({std::abs(off_edv), std::abs(off_esv), std::abs(off_mean)}) < kClose) {
      fit.reference_volume_ml = beat.edv_ml;
      return fit;
    }
    if (targets.edv_ml > 0) {
      fit = at_weight(fit, std::clamp(fit.weight_kg / (1 + off_edv), 1.0, 500.0));
    }
    if (targets.esv_ml > 0) {
      fit.emax = std::clamp(fit.emax * std::pow(1 + off_esv, 1.2), 1.01 * fit.emin, 1e3);
    }
    if (targets.aortic_mean_mmhg > 0) {
      fit.resistance = std::clamp(fit.resistance / (1 + off_mean), 1e-3, 1e3);
    }
    fit.reference_volume_ml = std::clamp(fit.reference_volume_ml, fit.v0_ml, 1e4);
  }
  throw_invalid(
      "no circulation has these volumes and this pressure at this heart rate; change one");
}

CirculationParameters fit_to_heart(const CirculationParameters& start, double edv_ml, double esv_ml,
                                   double heart_rate_per_min) {
  CirculationParameters own = start;
  own.heart_rate_per_min = std::clamp(heart_rate_per_min, CirculationParameters::kSlowestPerMin,
                                      CirculationParameters::kQuickestPerMin);
  return fit_circulation(own, {.edv_ml = edv_ml,
                               .esv_ml = esv_ml,
                               .aortic_mean_mmhg = natural_beat(start).aortic_mean_mmhg});
}

}  // namespace beatlas::palpation
