#pragma once
/// Haptic devices by inverted control: a device runs the servo at its own cadence and calls a
/// function that turns its state into a force. That fits vendors' schedulers and loops of our own.
/// SI units; axes right, up, towards the user, from a place of the device's own (a simulated or
/// replayed hand moves along the axes it was made with).

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "runtime/base/geometry.h"

namespace beatlas::device {

struct DeviceState {
  double time_s = 0;  ///< of this tick; rises
  Vec3 position_m = Vec3::Zero();
  Vec3 velocity_m_s = Vec3::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  std::uint32_t buttons = 0;  ///< bit n: button n is down
  bool valid = true;          ///< false: the state cannot be trusted, no force may come of it
};

/// Force on the user [N]. Called on the servo's thread; must not throw, block or allocate.
using ServoFn = std::function<Vec3(const DeviceState&)>;

struct RunReport {
  std::int64_t ticks = 0;
  std::int64_t late_ticks = 0;  ///< began more than a period after they were due
  double worst_late_s = 0;      ///< [s] behind the time due; 0 where ticks are not paced
};

class Device {
 public:
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  virtual ~Device() = default;

  [[nodiscard]] virtual std::string name() const = 0;
  /// How many of DeviceState's a person can press on it.
  [[nodiscard]] virtual int buttons() const { return 0; }

  /// Calls `servo` every tick on this thread until `stop` is requested or the device has no more to
  /// play. @throws Error{Machine} if the device fails; the last force is zero then.
  virtual RunReport run(const ServoFn& servo, std::stop_token stop) = 0;

  /// Takes the force off while `run` hangs in a servo; any thread. It stays off until the servo
  /// gives the next one. Nothing to do where the force moves nobody's hand.
  virtual void drop_force() noexcept {}
};

}  // namespace beatlas::device
