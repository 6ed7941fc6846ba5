#include "runtime/device/lever.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include "runtime/base/error.h"

namespace beatlas::device {
namespace {
// A controller sends at the servo's rate or so: 20 ticks without a line is a cable that is off.
constexpr int kMostMisses = 20;
}  // namespace

void LeverGeometry::check() const {
  if (!(arm_m >= 0.005 && arm_m <= 1)) throw_invalid("a lever's arm must be from 0.005 to 1 m");
  if (!std::isfinite(zero_rad)) throw_invalid("a lever's zero must be an angle");
  if (!(least_force_n >= 0 && least_force_n <= 1)) {
    throw_invalid("a lever's smallest force must be from 0 to 1 N");
  }
}

double LeverGeometry::displacement_m(double angle_rad) const noexcept {
  return arm_m * std::sin(angle_rad - zero_rad);
}

double LeverGeometry::speed_m_s(double angle_rad, double turning_rad_s) const noexcept {
  return arm_m * std::cos(angle_rad - zero_rad) * turning_rad_s;
}

double LeverGeometry::torque_n_m(double angle_rad, double force_n) const noexcept {
  if (!(std::abs(force_n) >= least_force_n)) return 0;
  return force_n * arm_m * std::cos(angle_rad - zero_rad);
}

LineAxis::LineAxis(const std::string& path)
    : file_(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {
  if (file_ < 0) {
    throw Error(ErrorCode::Machine, "the lever's line " + path +
                                        " cannot be opened; plug it in, check its rights, or use "
                                        "another --device");
  }
  termios settings{};
  if (::isatty(file_) != 0 && ::tcgetattr(file_, &settings) == 0) {
    ::cfmakeraw(&settings);
    (void)::tcsetattr(file_, TCSANOW, &settings);
  }
}

LineAxis::~LineAxis() {
  (void)set_torque(0);
  ::close(file_);
}

bool LineAxis::read(double& angle_rad) noexcept {
  std::array<char, 256> part;
  bool fresh = false;
  for (int n = 0; n < 16; ++n) {  // what has come since; never without an end
    const ssize_t got = ::read(file_, part.data(), part.size());
    if (got <= 0) break;
    for (char c : std::string_view(part.data(), static_cast<std::size_t>(got))) {
      if (c != '\n') {
        if (length_ < kLongestLine) {
          line_[length_++] = c;
        } else {
          too_long_ = true;
        }
        continue;
      }
      if (length_ > 0 && line_[length_ - 1] == '\r') --length_;
      double angle = 0;
      const auto [end, error] = std::from_chars(line_, line_ + length_, angle);
      fresh = !too_long_ && error == std::errc() && end == line_ + length_ && std::isfinite(angle);
      has_angle_ = fresh;  // a damaged line is no angle until a sound one comes
      if (fresh) angle_rad_ = angle;
      length_ = 0;
      too_long_ = false;
    }
    if (static_cast<std::size_t>(got) < part.size()) break;
  }
  misses_ = fresh ? 0 : std::min(misses_ + 1, kMostMisses + 1);
  angle_rad = angle_rad_;
  return has_angle_ && misses_ <= kMostMisses;
}

bool LineAxis::set_torque(double torque_n_m) noexcept {
  std::array<char, 40> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size() - 1, torque_n_m,
                                          std::chars_format::fixed, 6);
  if (error != std::errc()) return false;
  *end = '\n';
  const ssize_t size = end + 1 - text.data();
  return ::write(file_, text.data(), static_cast<std::size_t>(size)) == size;
}

LeverDevice::LeverDevice(std::unique_ptr<RotaryAxis> axis, const LeverOptions& options)
    : axis_(std::move(axis)), options_(options) {
  if (!axis_) throw_invalid("a lever needs an axis");
  options.geometry.check();
  if (!options.direction.allFinite() || !(options.direction.norm() > 0)) {
    throw_invalid("a lever needs a direction that is not zero");
  }
  if (!(options.patience_s >= 0.01 && options.patience_s <= 60)) {
    throw_invalid("a lever's patience must be from 0.01 to 60 s");
  }
  options_.direction.normalize();
}

LeverDevice::~LeverDevice() { drop_force(); }

RunReport LeverDevice::run(const ServoFn& servo, std::stop_token stop) {
  Pacer pacer(options_.pace, options_.rate_hz);
  const LeverGeometry& geometry = options_.geometry;
  RunReport report;
  double angle = 0;
  double last_angle = 0;
  double last_s = 0;
  double sound_s = 0;
  bool first = true;
  while (!stop.stop_requested()) {
    DeviceState state;
    state.time_s = pacer.next();
    const bool read = axis_->read(angle);
    state.valid = read && std::abs(angle - geometry.zero_rad) <= LeverGeometry::kLargestRad;
    if (state.valid) {
      const double elapsed_s = state.time_s - last_s;
      const double turning = first || !(elapsed_s > 0) ? 0 : (angle - last_angle) / elapsed_s;
      state.position_m = geometry.displacement_m(angle) * options_.direction;
      state.velocity_m_s = geometry.speed_m_s(angle, turning) * options_.direction;
      last_angle = angle;
      last_s = state.time_s;
      first = false;
    } else {
      state.position_m = geometry.displacement_m(last_angle) * options_.direction;
    }
    const Vec3 force_n = servo(state);
    const double along = force_n.dot(options_.direction);
    const bool sent = axis_->set_torque(
        state.valid && std::isfinite(along) ? geometry.torque_n_m(angle, along) : 0);
    report = pacer.report();
    if (state.valid && sent) sound_s = state.time_s;
    if (state.time_s - sound_s > options_.patience_s) {
      drop_force();
      throw Error(ErrorCode::Machine,
                  "the lever was lost: no sound angle comes or no torque is taken; check its cable "
                  "and start again, or use another --device");
    }
  }
  drop_force();
  return report;
}

}  // namespace beatlas::device
