#pragma once
/// What a device's servo calls every tick: model, then safety stage.

#include <memory>

#include "runtime/haptics/safety.h"
#include "runtime/haptics/two_step.h"

namespace beatlas::haptics {

struct Tick {
  TickStatus status = TickStatus::Fault;
  Vec3 force_n = Vec3::Zero();  ///< safe to send; workspace axes
  Contact contact;              ///< what the model said, before the safety stage
};

/// One user point on one structure. One thread; `tick` allocates, locks, logs and reads nothing.
class Servo {
 public:
  /// @throws Error{InvalidInput} as its parts do.
  Servo(std::shared_ptr<const field::FieldQuery> field, const TwoStepOptions& model,
        const SafetyOptions& safety);

  [[nodiscard]] Tick tick(const ServoState& state) noexcept;

  void stop() noexcept { safety_.stop(); }
  void restart() noexcept;

 private:
  TwoStepModel model_;
  SafetyStage safety_;
};

}  // namespace beatlas::haptics
