#pragma once
/// The one-axis lever of paper B: the user turns a lever about a hinge; in the scene that is
/// straight motion along one direction.

#include <atomic>
#include <memory>
#include <string>

#include "runtime/device/device.h"
#include "runtime/device/pacer.h"

namespace beatlas::device {

/// Rotary angle <-> straight displacement along the tangent at the zero angle,
///
///   s = r sin(a),   torque = F r cos(a),
///
/// so that torque times turning speed is force times speed at every angle: the conversion neither
/// makes nor takes energy. Angles beyond +-80 degrees are no state of this lever.
struct LeverGeometry {
  double arm_m = 0.06;  ///< [m] 0.005..1: from the hinge to the finger
  double zero_rad = 0;  ///< [rad] the encoder's angle where s is 0
  /// [N] 0..1: a smaller force along the axis is not transmitted; paper B's 5 gf.
  double least_force_n = 0.049;

  static constexpr double kLargestRad = 1.3962634015954636;  // 80 degrees

  /// @throws Error{InvalidInput} if a number is out of range.
  void check() const;
  [[nodiscard]] double displacement_m(double angle_rad) const noexcept;
  [[nodiscard]] double speed_m_s(double angle_rad, double turning_rad_s) const noexcept;
  [[nodiscard]] double torque_n_m(double angle_rad, double force_n) const noexcept;
};

/// A motor with an encoder.
class RotaryAxis {
 public:
  RotaryAxis() = default;
  RotaryAxis(const RotaryAxis&) = delete;
  RotaryAxis& operator=(const RotaryAxis&) = delete;
  virtual ~RotaryAxis() = default;

  /// The newest angle [rad]; false if there is none to be trusted. Does not wait.
  [[nodiscard]] virtual bool read(double& angle_rad) noexcept = 0;
  /// [N m]; false if it cannot be sent. Any thread.
  virtual bool set_torque(double torque_n_m) noexcept = 0;
};

/// A motor controller on a serial line (or any file that can be read and written): it sends an
/// angle in rad a line, as often as it likes, and takes a torque in N m a line.
class LineAxis final : public RotaryAxis {
 public:
  /// @param path such as /dev/ttyACM0; a terminal is set to raw bytes, its speed left as it is.
  /// @throws Error{Machine} if it cannot be opened.
  explicit LineAxis(const std::string& path);
  ~LineAxis() override;

  [[nodiscard]] bool read(double& angle_rad) noexcept override;
  bool set_torque(double torque_n_m) noexcept override;

 private:
  static constexpr std::size_t kLongestLine = 64;

  int file_ = -1;
  char line_[kLongestLine] = {};
  std::size_t length_ = 0;
  bool too_long_ = false;
  bool has_angle_ = false;
  double angle_rad_ = 0;
  int misses_ = 0;  // reads in a row without a new angle
};

struct LeverOptions {
  LeverGeometry geometry = {};
  Vec3 direction = Vec3::UnitZ();  ///< device frame, any length but 0: where s is positive
  double rate_hz = 1000;           ///< [1/s]
  Pace pace = Pace::RealTime;
  double patience_s = 0.5;  ///< [s] 0.01..60: without a sound angle for longer the lever is lost
};

class LeverDevice final : public Device {
 public:
  /// @throws Error{InvalidInput} if there is no axis or an option is out of range.
  LeverDevice(std::unique_ptr<RotaryAxis> axis, const LeverOptions& options);
  ~LeverDevice() override;

  [[nodiscard]] std::string name() const override { return "lever"; }
  RunReport run(const ServoFn& servo, std::stop_token stop) override;
  void drop_force() noexcept override { (void)axis_->set_torque(0); }

 private:
  std::unique_ptr<RotaryAxis> axis_;
  LeverOptions options_;
};

}  // namespace beatlas::device
