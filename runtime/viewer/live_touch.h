#pragma once
/// The servo's own thread, and what moves the tool in it.

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

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

/// A touch that runs in a thread of its own, whatever the picture does. It begins with the mouse,
/// which takes over again when a device is lost or has no more to play.
class LiveTouch {
 public:
  LiveTouch(std::unique_ptr<Touch> touch, const Vec3& tool_mm);
  ~LiveTouch();
  LiveTouch(const LiveTouch&) = delete;
  LiveTouch& operator=(const LiveTouch&) = delete;

  [[nodiscard]] Touch& touch() { return *touch_; }
  [[nodiscard]] MouseDevice& mouse() { return mouse_; }

  // One thread.
  /// Ends what moved the tool before and waits for that; the force comes by the start ramp.
  void use(ReadyDevice ready);
  void use_mouse() { use({}); }
  /// "mouse", "haply", ...: what moves the tool now.
  [[nodiscard]] std::string device() const;
  /// Why the mouse has taken over, as a sentence; once, empty otherwise.
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

  std::unique_ptr<Touch> touch_;
  MouseDevice mouse_;
  TickTimes compute_;
  TickTimes late_;
  double last_s_ = 0;  // the servo's time goes on from device to device
  device::RunReport report_;
  mutable std::mutex told_;  // never a tick's
  std::string device_ = "mouse";
  std::string trouble_;
  std::jthread thread_;  // last: it ends before what it uses
};

}  // namespace beatlas::viewer
