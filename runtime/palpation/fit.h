#pragma once
/// A circulation that fits a heart: its volumes, and the mean pressure in its aorta.

#include "runtime/palpation/circulation.h"

namespace beatlas::palpation {

/// The beat that comes again and again without a finger, at 1 ms.
/// @throws Error{InvalidInput} as Circulation.
[[nodiscard]] Beat natural_beat(const CirculationParameters& parameters);

struct Targets {
  double edv_ml = 0;  ///< > 0: scale to this end-diastolic volume by the weight; 0: leave it
  double esv_ml = 0;  ///< > 0, below edv_ml: by Emax; 0: leave it
  double aortic_mean_mmhg = 0;  ///< > 0, above the right atrium's: by the resistance; 0: leave it
};

/// The parameters whose natural beat has what `targets` names, within 0.1 %, with
/// `reference_volume_ml` set to its end-diastolic volume. The weight begins at 25 kg a 49.8 ml.
/// @throws Error{InvalidInput} if a target is out of range or no circulation in range has it.
[[nodiscard]] CirculationParameters fit_circulation(const CirculationParameters& start,
                                                    const Targets& targets);

/// `start` scaled to another heart: its volumes, its rate (taken to 30..220 a minute), against the
/// mean aortic pressure that `start` has at its own rate. @throws Error{InvalidInput} as
/// fit_circulation.
[[nodiscard]] CirculationParameters fit_to_heart(const CirculationParameters& start, double edv_ml,
                                                 double esv_ml, double heart_rate_per_min);

}  // namespace beatlas::palpation
