#include "runtime/palpation/patch_stiffness.h"

#include <cmath>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::palpation {

PatchStiffness::PatchStiffness(std::shared_ptr<const AtlasMuscle> muscle,
                               const PalpationParameters& parameters, double period_s,
                               double end_diastole_s)
    : muscle_(std::move(muscle)),
      curve_(period_s, parameters.whole_circulation().relaxation_rate_per_s),
      end_diastole_s_(end_diastole_s) {
  if (!muscle_) throw_invalid("a stiffness from place to place needs the muscle of an atlas");
}

double PatchStiffness::n_per_m(const Vec3& surface_mm, double t) const noexcept {
  const double beats = (t - end_diastole_s_) / curve_.period_s();
  const double e = curve_.at((beats - std::floor(beats)) * curve_.period_s()).value;
  return muscle_->under(surface_mm, t / curve_.period_s(), trail_).n_per_m(e);
}

}  // namespace beatlas::palpation
