#pragma once
/// The servos' own threads, and what moves the tools in them.

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "runtime/device/device.h"
#include "runtime/haptics/seqlock.h"
#include "runtime/viewer/tick_times.h"
#include "runtime/viewer/touch.h"

namespace beatlas::viewer {

/// The mouse: a point that another thread moves; it goes there smoothly (60 ms), in steps of 1 ms.
class MouseDevice final : public device::Device {
 public:
  explicit MouseDevice(const Vec3& position_mm);
  [[nodiscard]] std::string name() const override { return "mouse"; }
  device::RunReport run(const device::ServoFn& servo, std::stop_token stop) override;
  /// One thread at a time. Workspace.
  void move_to(const Vec3& position_mm) noexcept;
  /// It is there at the next tick without having been on the way: what was touched is let go of,
  /// and the force begins anew, by the start ramp.
  void put_at(const Vec3& position_mm) noexcept;

 private:
  struct Wish {
    std::array<double, 3> mm{};
    std::uint64_t puts = 0;
  };
  haptics::Seqlock<Wish> wished_;
  std::uint64_t puts_ = 0;       ///< the caller's
  std::uint64_t puts_seen_ = 0;  ///< the servo's
  Vec3 position_mm_;
};

/// A device that is there, and where its point goes: mm from mm, rigid.
struct ReadyDevice {
  std::unique_ptr<device::Device> device;
  Affine workspace_from_device = Affine::Identity();
};

/// A finger's thread, whatever the picture does.
class LiveFinger {
 public:
  /// @param mouse takes over where a device is lost or has no more to play; null: the finger is
  /// lifted then
  LiveFinger(Touch& touch, std::size_t finger, MouseDevice* mouse);
  ~LiveFinger();
  LiveFinger(const LiveFinger&) = delete;
  LiveFinger& operator=(const LiveFinger&) = delete;

  // One thread.
  /// Ends what moved the tool before and waits for that; the force comes by the start ramp.
  /// @param ready without a device: the mouse
  void use(ReadyDevice ready);
  /// "mouse", "haply", ...: what moves the tool now; empty: nothing.
  [[nodiscard]] std::string device() const;
  /// Why nothing or the mouse has taken over, as a sentence; once, empty otherwise.
  [[nodiscard]] std::string take_trouble();
  /// Ends the thread: no force is sent from then on. @return how the last device ran
  device::RunReport stop();

  /// Of all ticks since `forget`: compute time (wall clock, the circulation included), and how long
  /// after the first one's pace a tick began.
  [[nodiscard]] const TickTimes& compute_times() const noexcept { return compute_; }
  [[nodiscard]] const TickTimes& late_times() const noexcept { return late_; }
  void forget_times() noexcept;

 private:
  void run(device::Device& device, const Affine& workspace_from_device,
           const std::stop_token& stop);
  void tell(const std::string& device, const std::string& trouble);

  Touch& touch_;
  std::size_t finger_;
  MouseDevice* mouse_;
  TickTimes compute_;
  TickTimes late_;
  double last_s_ = 0;  // the servo's time goes on from device to device
  device::RunReport report_;
  mutable std::mutex told_;  // never a tick's
  std::string device_;
  std::string trouble_;
  std::jthread thread_;  // last: it ends before what it uses
};

/// A touch whose fingers run in threads of their own. The first begins with the mouse, which takes
/// over again when a device is lost or has no more to play; the others are nowhere until they are
/// given a device.
class LiveTouch {
 public:
  LiveTouch(std::unique_ptr<Touch> touch, const Vec3& tool_mm);

  [[nodiscard]] Touch& touch() { return *touch_; }
  [[nodiscard]] MouseDevice& mouse() { return mouse_; }
  [[nodiscard]] LiveFinger& finger(std::size_t n) { return *fingers_[n]; }

  // Of the first finger, as LiveFinger has them.
  void use(ReadyDevice ready) { fingers_.front()->use(std::move(ready)); }
  void use_mouse() { use({}); }
  [[nodiscard]] std::string device() const { return fingers_.front()->device(); }
  [[nodiscard]] const TickTimes& compute_times() const { return fingers_.front()->compute_times(); }
  [[nodiscard]] const TickTimes& late_times() const { return fingers_.front()->late_times(); }
  void forget_times() noexcept { fingers_.front()->forget_times(); }

  [[nodiscard]] std::string take_trouble() { return fingers_.front()->take_trouble(); }
  /// Ends all threads. @return how the first finger's last device ran
  device::RunReport stop();

 private:
  std::unique_ptr<Touch> touch_;
  MouseDevice mouse_;
  std::vector<std::unique_ptr<LiveFinger>> fingers_;
};

}  // namespace beatlas::viewer
