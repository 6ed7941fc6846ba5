#pragma once
/// An exercise that is played beside the window, in a thread of its own (runtime/app).

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "runtime/app/exercise_session.h"
#include "runtime/app/play_options.h"
#include "runtime/viewer/live_touch.h"

namespace beatlas::viewer {

class LiveExercise {
 public:
  /// What is to be seen of it.
  struct Seen {
    bool playing = false;  ///< false: between trials, or over; the rest is of the last one then
    haptics::Published servo;
    std::size_t trial = 0;  ///< from 0
    int marks = 0;          ///< that are to be made
    int made = 0;
    double seconds = 0;  ///< left
    std::vector<Vec3> places_mm;
  };

  /// Begins it. @param arguments with an exercise that can be read and a session
  /// @param tool_mm where the mouse's tool is first
  LiveExercise(const app::PlayArguments& arguments, const Vec3& tool_mm);
  ~LiveExercise();
  LiveExercise(const LiveExercise&) = delete;
  LiveExercise& operator=(const LiveExercise&) = delete;

  // One thread.
  [[nodiscard]] MouseDevice& mouse() { return mouse_; }
  [[nodiscard]] const exercise::Exercise& exercise() const { return exercise_; }
  /// Whether the mouse moves the tool, and no device.
  [[nodiscard]] bool with_mouse() const { return arguments_.device == mouse_.name(); }
  [[nodiscard]] Seen seen();
  /// The place that is touched is marked as the n-th kind, from 0.
  void mark(std::size_t kind) noexcept;
  /// Once, when it is over: the score in words, or why it was broken off.
  [[nodiscard]] std::optional<std::string> take_end();
  /// Breaks it off; what was played is kept.
  void stop();

 private:
  void play(const std::stop_token& stop);

  app::PlayArguments arguments_;
  exercise::Exercise exercise_;
  MouseDevice mouse_;
  std::atomic<std::uint32_t> marks_{0};  ///< since the last tick
  std::mutex told_;                      // never a tick's
  const haptics::Servo* servo_ = nullptr;
  const std::atomic<int>* made_ = nullptr;
  double part_s_ = 0;
  Seen seen_;
  std::optional<std::string> end_;
  std::jthread thread_;  // last: it ends before what it uses
};

}  // namespace beatlas::viewer
