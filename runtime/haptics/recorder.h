#pragma once
/// The last ticks of a servo, whole: what went in, what was remembered, what came out.

#include <array>
#include <atomic>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/haptics/contact.h"
#include "runtime/haptics/heart_clock.h"
#include "runtime/haptics/safety.h"

namespace beatlas::haptics {

/// The first line of a file of ticks.
inline constexpr std::string_view kTicksFormat = "beatlas ticks 1";

/// All that a servo remembers from tick to tick.
struct ServoMemory {
  ModelMemory model{};
  HeartClock::Memory heart{};
  SafetyStage::Memory safety{};
  double last_time_s = 0;
  double ran = 0;  ///< 1 after the first good tick
};

/// Trivially copyable. `restore(before)` and a tick of the same input give the same output, bit by
/// bit, on one kind of machine.
struct TickRecord {
  // What went in.
  double time_s = 0;
  std::array<double, 3> position_mm{};
  std::array<double, 4> orientation{0, 0, 0, 1};  ///< x y z w
  bool valid = false;
  bool stopped = false;
  bool restarted = false;   ///< by a caller, before this tick
  std::uint32_t scene = 0;  ///< which one: counts hot swaps
  HeartWish wish;
  ServoMemory before;
  // What came out.
  TickStatus status = TickStatus::Fault;
  std::array<double, 3> force_n{};
  std::array<double, 3> model_force_n{};
  double distance_mm = 0;
};

/// A ring that the servo's thread writes without waiting and another thread reads once it is
/// frozen.
class Recorder {
 public:
  /// @param ticks how many are kept, 0: none. @param after_fault ticks that are still recorded
  /// after the first fault; then the ring is frozen until `resume`. Memory is taken here, never
  /// later.
  explicit Recorder(std::size_t ticks, std::size_t after_fault = 100);

  static constexpr std::size_t kMostTicks = 1U << 20U;  ///< 17 min at 1 kHz; about 500 MB

  /// Servo's thread.
  void record(const TickRecord& record) noexcept;

  /// Any other thread: asks the servo to freeze at its next tick.
  void ask() noexcept { asked_.store(true, std::memory_order_release); }
  /// Whether the ring can be read. After the servo's thread has ended it can be read in any case.
  [[nodiscard]] bool frozen() const noexcept { return frozen_.load(std::memory_order_acquire); }
  /// Oldest first. Only while frozen, or when the servo's thread has ended.
  [[nodiscard]] std::vector<TickRecord> ticks() const;
  /// Goes on recording, with an empty ring.
  void resume() noexcept;

 private:
  std::vector<TickRecord> ring_;
  std::size_t after_fault_;
  std::size_t written_ = 0;
  std::size_t left_ = 0;  // ticks until the ring freezes, once a fault was seen
  bool faulted_ = false;
  std::atomic<bool> asked_{false};
  std::atomic<bool> frozen_{false};
};

/// Text: a line that names the format, a line of the caller's (`about`, no line break), a line that
/// names the columns, and a tick a line; numbers read back to the bit.
void write_ticks(std::ostream& out, const std::string& about, const std::vector<TickRecord>& ticks);

struct RecordedTicks {
  std::string about;
  std::vector<TickRecord> ticks;
};
/// @param name of the file, for messages. @throws Error{InvalidInput} naming line and column.
[[nodiscard]] RecordedTicks read_ticks(std::istream& in, const std::string& name);

}  // namespace beatlas::haptics
