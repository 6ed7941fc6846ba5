#include "runtime/haptics/servo.h"

#include <cmath>
#include <utility>

namespace beatlas::haptics {

Servo::Servo(std::shared_ptr<const field::FieldQuery> field, const TwoStepOptions& model,
             const SafetyOptions& safety)
    : model_(std::move(field), model), safety_(safety) {}

Tick Servo::tick(const ServoState& state) noexcept {
  Tick tick;
  const bool valid = state.valid && state.position_mm.allFinite() && std::isfinite(state.time_s);
  if (valid) tick.contact = model_.evaluate(state.position_mm, state.time_s);
  const SafeForce safe =
      safety_.apply(tick.contact.force_n, tick.contact.depth_mm, state.time_s, valid);
  if (safe.status == TickStatus::Fault) model_.reset();
  tick.status = safe.status;
  tick.force_n = safe.force_n;
  return tick;
}

void Servo::restart() noexcept {
  model_.reset();
  safety_.restart();
}

}  // namespace beatlas::haptics
