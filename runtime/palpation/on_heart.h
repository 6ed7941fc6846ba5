#pragma once
/// A lesson's parameters on another heart than the dog's of 25 kg.

#include "runtime/palpation/parameters.h"

namespace beatlas::palpation {

/// Volumes and rate of a heart, as an atlas holds them.
struct HeartSize {
  double edv_ml = 0;
  double esv_ml = 0;
  double heart_rate_per_min = 0;
};

/// The healthy ventricle of paper B is made as large as `heart` and as strong (fit_to_heart), and
/// `told` changes it as it would have changed the dog's: each number of its circulation that has a
/// size is multiplied by what the fit multiplied the healthy one by. So a lower pressure in the
/// atrium empties this ventricle, an infarct weakens it, and neither is taken for a heart of
/// another size. The reference volume is the end-diastolic volume that results.
/// @throws Error{InvalidInput} if no circulation in range has these volumes, or what results is out
/// of range
[[nodiscard]] PalpationParameters on_heart(const PalpationParameters& told, const HeartSize& heart);

}  // namespace beatlas::palpation
