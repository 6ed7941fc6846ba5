#include "runtime/viewer/live_touch.h"

#include <cmath>
#include <exception>
#include <optional>
#include <utility>

#include <pthread.h>

#include "runtime/device/pacer.h"
#include "runtime/haptics/watchdog.h"

namespace beatlas::viewer {
namespace {

constexpr double kMouseSettlingS = 0.06;

// Where OpenGL is drawn by software a picture takes every core there is: a tick goes first, if the
// system lets it (RLIMIT_RTPRIO). It sleeps nearly all the time.
void go_first() noexcept {
  const sched_param wished{.sched_priority = sched_get_priority_min(SCHED_RR)};
  (void)pthread_setschedparam(pthread_self(), SCHED_RR, &wished);
}

}  // namespace

MouseDevice::MouseDevice(const Vec3& position_mm) : position_mm_(position_mm) {
  move_to(position_mm);
}

void MouseDevice::move_to(const Vec3& position_mm) noexcept {
  if (!position_mm.allFinite()) return;
  wished_.write({.mm = {position_mm.x(), position_mm.y(), position_mm.z()}, .puts = puts_});
}

void MouseDevice::put_at(const Vec3& position_mm) noexcept {
  if (!position_mm.allFinite()) return;
  ++puts_;
  move_to(position_mm);
}

device::RunReport MouseDevice::run(const device::ServoFn& servo, std::stop_token stop) {
  device::Pacer pacer(device::Pace::RealTime, 1 / kTickS);
  double last_s = 0;
  Wish wish = wished_.read();
  while (!stop.stop_requested()) {
    device::DeviceState state;
    state.time_s = pacer.next();
    (void)wished_.try_read(wish);  // While one is being written, the last one counts.
    const Vec3 target(wish.mm[0], wish.mm[1], wish.mm[2]);
    const Vec3 before = position_mm_;
    // A tick that says nothing lies between the old place and the new one.
    state.valid = wish.puts == puts_seen_;
    if (state.valid) {
      const double share = 1 - std::exp(-(state.time_s - last_s) / kMouseSettlingS);
      position_mm_ += share * (target - position_mm_);
    } else {
      position_mm_ = target;
      puts_seen_ = wish.puts;
    }
    if (state.valid && state.time_s > last_s) {
      state.velocity_m_s = kMPerMm * (position_mm_ - before) / (state.time_s - last_s);
    }
    last_s = state.time_s;
    state.position_m = kMPerMm * position_mm_;
    (void)servo(state);  // nobody's hand is moved
  }
  return pacer.report();
}

LiveFinger::LiveFinger(Touch& touch, std::size_t finger, MouseDevice* mouse)
    : touch_(touch), finger_(finger), mouse_(mouse) {}

LiveFinger::~LiveFinger() { stop(); }

void LiveFinger::use(ReadyDevice ready) {
  stop();
  const std::string otherwise = mouse_ != nullptr ? mouse_->name() : "";
  tell(ready.device ? ready.device->name() : otherwise, {});
  thread_ = std::jthread(
      [this, otherwise, ready = std::move(ready)](const std::stop_token& stop) mutable {
        go_first();
        const char* const next = mouse_ != nullptr ? "; the mouse moves the tool now." : ".";
        if (ready.device) {
          const std::string name = ready.device->name();
          std::string why = name + " has come to its end" + next;
          try {
            run(*ready.device, ready.workspace_from_device, stop);
          } catch (const std::exception& error) {
            why = name + " is lost, no force is sent (" + error.what() + ")" + next;
            if (mouse_ != nullptr) why += " Choose it again when it is back.";
          }
          // Whatever was felt last is over.
          last_s_ += kTickS;
          (void)touch_.tick({.time_s = last_s_, .valid = false}, finger_);
          ready.device.reset();
          if (mouse_ == nullptr) touch_.lift(finger_);
          if (stop.stop_requested()) return;
          tell(otherwise, why);
        }
        if (mouse_ != nullptr) run(*mouse_, Affine::Identity(), stop);
      });
}

void LiveFinger::run(device::Device& device, const Affine& workspace_from_device,
                     const std::stop_token& stop) {
  haptics::Servo& servo = touch_.servo(finger_);
  servo.restart();
  std::optional<haptics::Watchdog> watchdog;
  if (&device != mouse_) {
    watchdog.emplace([&device] { device.drop_force(); }, haptics::WatchdogOptions{});
  }
  const double begin_s = last_s_ + kTickS;
  std::optional<std::int64_t> begin_ns;
  const Eigen::Matrix3d turn = workspace_from_device.linear();
  const device::ServoFn tick = [&](const device::DeviceState& state) -> Vec3 {
    const std::int64_t began_ns = clock_ns();
    const auto due_ns = static_cast<std::int64_t>(1e9 * state.time_s);
    if (!begin_ns) begin_ns = began_ns - due_ns;
    late_.add(began_ns - due_ns - *begin_ns);
    last_s_ = begin_s + state.time_s;
    const Vec3 force_n =
        touch_.tick({.time_s = last_s_,
                     .position_mm = workspace_from_device * (state.position_m / kMPerMm),
                     .valid = state.valid,
                     .orientation = Eigen::Quaterniond(turn) * state.orientation},
                    finger_);
    compute_.add(clock_ns() - began_ns);
    if (watchdog && !watchdog->beat()) {  // a stall: the force is off, and comes back by the ramp
      servo.restart();
      return Vec3::Zero();
    }
    return turn.transpose() * force_n;
  };
  report_ = device.run(tick, stop);
}

void LiveFinger::tell(const std::string& device, const std::string& trouble) {
  const std::scoped_lock lock(told_);
  device_ = device;
  trouble_ = trouble;
}

std::string LiveFinger::device() const {
  const std::scoped_lock lock(told_);
  return device_;
}

std::string LiveFinger::take_trouble() {
  const std::scoped_lock lock(told_);
  return std::exchange(trouble_, {});
}

device::RunReport LiveFinger::stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  return report_;
}

void LiveFinger::forget_times() noexcept {
  compute_.clear();
  late_.clear();
}

LiveTouch::LiveTouch(std::unique_ptr<Touch> touch, const Vec3& tool_mm)
    : touch_(std::move(touch)), mouse_(tool_mm) {
  for (std::size_t n = 0; n < touch_->fingers(); ++n) {
    fingers_.push_back(std::make_unique<LiveFinger>(*touch_, n, n == 0 ? &mouse_ : nullptr));
  }
  use_mouse();
}

device::RunReport LiveTouch::stop() {
  for (std::size_t n = fingers_.size(); n-- > 1;) (void)fingers_[n]->stop();
  return fingers_.front()->stop();
}

}  // namespace beatlas::viewer
