#pragma once
/// What a device's servo calls every tick: the heart's time, a model, then the safety stage.
///
/// Two threads. The servo's calls `tick` alone. Another one, "the caller's", may at any time wish
/// for a heart rate, stop, offer another scene, look at what was published and read a frozen
/// recording.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "runtime/haptics/hand_over.h"
#include "runtime/haptics/heart_clock.h"
#include "runtime/haptics/recorder.h"
#include "runtime/haptics/safety.h"
#include "runtime/haptics/scene.h"
#include "runtime/haptics/seqlock.h"

namespace beatlas::haptics {

struct Tick {
  TickStatus status = TickStatus::Fault;
  Vec3 force_n = Vec3::Zero();  ///< safe to send; workspace axes
  Contact contact;              ///< what the model said, before the safety stage
};

struct ServoOptions {
  SafetyOptions safety;
  HeartOptions heart;
  std::size_t recorded_ticks = 0;  ///< the last ones, kept for a fault; 0: none
};

/// For graphics: one tick as a whole. Trivially copyable; workspace frame.
struct Published {
  std::uint64_t ticks = 0;  ///< how many there were
  double time_s = 0;
  double phase = 0;  ///< of the cycle, 0..1
  double rate_hz = 0;
  std::array<double, 3> position_mm{};
  std::array<double, 4> orientation{0, 0, 0, 1};  ///< workspace_from_tool: x y z w
  std::array<double, 3> proxy_mm{};
  std::array<double, 3> normal{};
  std::array<double, 3> force_n{};
  double distance_mm = 0;
  TickStatus status = TickStatus::Fault;
  bool touching = false;
};

/// One tool on one scene. `tick` allocates, locks, logs and reads nothing.
class Servo {
 public:
  /// @throws Error{InvalidInput} as its parts do, and if there is no model.
  Servo(Scene scene, const ServoOptions& options);
  ~Servo() = default;
  Servo(const Servo&) = delete;
  Servo& operator=(const Servo&) = delete;

  [[nodiscard]] Tick tick(const ServoState& state) noexcept;
  /// Of the heart's cycle, as of the last tick.
  [[nodiscard]] double phase() const noexcept { return heart_.phase(); }

  // The caller's thread.
  /// Zero force from the next tick on, until `restart`.
  void stop() noexcept { stopped_.store(true, std::memory_order_relaxed); }
  /// Begins anew, with the start ramp, at the next tick.
  void restart() noexcept;
  void set_rate_hz(double rate_hz) noexcept { rate_hz_.store(rate_hz, std::memory_order_relaxed); }
  void set_paused(bool paused) noexcept { paused_.store(paused, std::memory_order_relaxed); }
  /// 0..1: beat on to this phase and stay; below 0: let go.
  void hold_phase(double phase) noexcept { hold_phase_.store(phase, std::memory_order_relaxed); }
  /// Another scene from the next tick on. Where it has the same period and a model that takes over
  /// from the one before (ForceModel), contact and force go on, and change as fast as the safety
  /// stage lets them. Any other gives zero force in that tick; the force comes back by the start
  /// ramp. The servo's thread neither waits nor frees: the scene that was replaced, and an offer
  /// that was never taken up, are freed by the next call of this, by `collect` or with the servo.
  /// @throws Error{InvalidInput} if there is no model or the period is no positive number.
  void offer(Scene scene);
  void collect() noexcept { scenes_.collect(); }
  [[nodiscard]] Published published() const noexcept { return published_.read(); }
  [[nodiscard]] Recorder& recorder() noexcept { return recorder_; }

  /// Ticks once more what was recorded, from what was remembered then; the servo's thread, or none.
  [[nodiscard]] Tick replay(const TickRecord& record) noexcept;
  [[nodiscard]] ServoMemory memory() const noexcept;

 private:
  [[nodiscard]] Tick run(const ServoState& state, const HeartWish& wish) noexcept;
  /// Whether there is another scene that does not go on where the one before was.
  [[nodiscard]] bool take_up_offer() noexcept;
  void restore(const ServoMemory& memory) noexcept;

  std::unique_ptr<Scene> scene_;
  HeartClock heart_;
  SafetyStage safety_;
  Recorder recorder_;
  double last_time_s_ = 0;
  bool ran_ = false;
  std::uint64_t ticks_ = 0;
  std::uint32_t scene_number_ = 0;
  std::uint32_t restarts_seen_ = 0;

  std::atomic<bool> stopped_{false};
  std::atomic<std::uint32_t> restarts_{0};
  std::atomic<double> rate_hz_;
  std::atomic<bool> paused_{false};
  std::atomic<double> hold_phase_{-1};
  HandOver<Scene> scenes_;
  Seqlock<Published> published_;
};

/// Whether every tick of a recording, taken up where it was, comes out again to the bit. Ticks of
/// another scene than the servo's (`scene`) are passed over.
struct ReplayReport {
  std::size_t ticks = 0;      ///< replayed
  std::size_t different = 0;  ///< of them: not the same to the bit
  std::size_t first_different = 0;
};
[[nodiscard]] ReplayReport replay_ticks(Servo& servo, const std::vector<TickRecord>& ticks,
                                        std::uint32_t scene = 0);

}  // namespace beatlas::haptics
