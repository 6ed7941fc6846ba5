#pragma once
#include <cstdint>
#include <istream>
#include <vector>

#include "runtime/device/device.h"
#include "runtime/device/pacer.h"

namespace beatlas::device {

/// A recorded path of the hand. time_s rises strictly.
struct Recording {
  std::vector<double> time_s;
  std::vector<Vec3> position_m;
  std::vector<std::uint32_t> buttons = {};  ///< of each row; empty: none is ever down
};

/// CSV with columns t_s, x_mm, y_mm, z_mm, and buttons where there are some (others are passed
/// over, so a force trace can be played again).
/// @throws Error{InvalidInput} naming line and column, that time does not rise, or that buttons are
/// no whole number.
[[nodiscard]] Recording read_recording(std::istream& stream, const std::string& name);

/// A row's column of buttons. @throws Error{InvalidInput} naming the row if it is no whole number
/// below 2^32  @param row counted from 1
[[nodiscard]] std::uint32_t buttons_of(double value, const std::string& name, std::size_t row);

struct ReplayOptions {
  double rate_hz = 1000;  ///< [1/s]: the recording is interpolated linearly to it
  Pace pace = Pace::RealTime;
};

/// Plays a recording once, from its first time to its last; forces move nothing.
class ReplayDevice final : public Device {
 public:
  /// @throws Error{InvalidInput} if the recording is empty or its times do not rise.
  ReplayDevice(Recording recording, const ReplayOptions& options);

  [[nodiscard]] std::string name() const override { return "replay"; }
  [[nodiscard]] double seconds() const {
    return recording_.time_s.back() - recording_.time_s.front();
  }
  RunReport run(const ServoFn& servo, std::stop_token stop) override;

 private:
  Recording recording_;
  ReplayOptions options_;
};

}  // namespace beatlas::device
