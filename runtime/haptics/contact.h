#pragma once
/// What every force model takes and gives.

#include <array>
#include <cstddef>

#include "runtime/base/geometry.h"

namespace beatlas::haptics {

/// What a device says at a tick, in the workspace's frame.
struct ServoState {
  double time_s = 0;                ///< of the device's clock; rises (SafetyStage::apply)
  Vec3 position_mm = Vec3::Zero();  ///< the user point: centre of the tool
  bool valid = true;                ///< false: the state cannot be trusted, no force comes of it
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< workspace_from_tool
};

/// Where a tick stands in the heart's own time.
struct Moment {
  double elapsed_s = 0;     ///< of the device's clock since the tick before; 0 at the first
  double field_time_s = 0;  ///< where the field is asked; it goes on without a wrap
  double speed = 1;         ///< d field time / d time: 0 paused, 2 twice the stored heart rate
};

struct Contact {
  Vec3 force_n = Vec3::Zero();       ///< before any cap; on the user, workspace axes
  double distance_mm = 0;            ///< of the tool from the surface, negative inside
  double depth_mm = 0;               ///< max(0, -distance); what the force is proportional to
  Vec3 normal = Vec3::Zero();        ///< outward; where it comes from is said by each model
  Vec3 proxy_mm = Vec3::Zero();      ///< where the tool's centre would be, had it not gone in
  double surface_velocity_mm_s = 0;  ///< along the normal; 0 while held
  bool touching = false;
  Vec3 torque_n_mm = Vec3::Zero();  ///< about the tool's centre; 0 for a point and a sphere
};

/// All that a model remembers from tick to tick, so that a recording can be taken up anywhere.
using ModelMemory = std::array<double, 16>;

/// From a state to a force. One thread; what runs in a tick neither throws, allocates nor locks.
class ForceModel {
 public:
  ForceModel() = default;
  ForceModel(const ForceModel&) = default;
  ForceModel(ForceModel&&) = default;
  ForceModel& operator=(const ForceModel&) = default;
  ForceModel& operator=(ForceModel&&) = default;
  virtual ~ForceModel() = default;

  /// @param state finite; Servo turns away what is not.
  [[nodiscard]] virtual Contact evaluate(const ServoState& state,
                                         const Moment& moment) noexcept = 0;
  /// Forgets the contact, as after a jump of the device.
  virtual void reset() noexcept = 0;
  /// `restore(memory())` leaves the model where it was, to the bit.
  [[nodiscard]] virtual ModelMemory memory() const noexcept = 0;
  virtual void restore(const ModelMemory& memory) noexcept = 0;
  /// Goes on where `before` is, if that is of the same kind, on the same field and with a tool of
  /// the same shape, so that what it remembers is true here, too; what may differ is how hard the
  /// surface is. Else false, and nothing is changed.
  [[nodiscard]] virtual bool take_over(const ForceModel& before) noexcept {
    (void)before;
    return false;
  }
};

}  // namespace beatlas::haptics
