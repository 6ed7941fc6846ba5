#include "runtime/viewer/live_exercise.h"

#include <algorithm>
#include <exception>
#include <sstream>
#include <utility>

namespace beatlas::viewer {
namespace {

/// The mouse, lent for a part of a trial.
class LentMouse final : public device::Device {
 public:
  explicit LentMouse(MouseDevice& mouse) : mouse_(mouse) {}
  [[nodiscard]] std::string name() const override { return mouse_.name(); }
  device::RunReport run(const device::ServoFn& servo, std::stop_token stop) override {
    return mouse_.run(servo, std::move(stop));
  }

 private:
  MouseDevice& mouse_;
};

}  // namespace

LiveExercise::LiveExercise(const app::PlayArguments& arguments, const Vec3& tool_mm)
    : arguments_(arguments),
      exercise_(app::read_exercise(arguments.exercise)),
      mouse_(tool_mm),
      thread_([this](const std::stop_token& stop) { play(stop); }) {}

LiveExercise::~LiveExercise() { stop(); }

void LiveExercise::play(const std::stop_token& stop) {
  app::ExerciseStage stage;
  stage.mouse = [this] { return std::make_unique<LentMouse>(mouse_); };
  stage.marks = [this] { return marks_.exchange(0, std::memory_order_relaxed); };
  stage.begins = [this](const app::ExercisePart& part) {
    const std::scoped_lock lock(told_);
    marks_.store(0);
    servo_ = &part.servo;
    made_ = &part.made;
    part_s_ = part.seconds;
    seen_ = {.playing = true,
             .servo = {},
             .trial = part.trial,
             .marks = part.marks,
             .made = 0,
             .seconds = part.seconds,
             .places_mm = part.places_mm};
  };
  stage.ends = [this] {
    const std::scoped_lock lock(told_);
    servo_ = nullptr;
    made_ = nullptr;
    seen_.playing = false;
  };
  stage.stop = stop;
  std::string words;
  try {
    std::ostringstream out;
    app::run_exercise(arguments_, out, &stage);
    words = out.str();
  } catch (const std::exception& error) {
    words = error.what();
  }
  const std::scoped_lock lock(told_);
  end_ = std::move(words);
}

LiveExercise::Seen LiveExercise::seen() {
  const std::scoped_lock lock(told_);
  if (servo_ != nullptr) {
    seen_.servo = servo_->published();
    seen_.made = made_->load(std::memory_order_relaxed);
    seen_.seconds = std::max(0.0, part_s_ - seen_.servo.time_s);
  }
  return seen_;
}

void LiveExercise::mark(std::size_t kind) noexcept {
  marks_.fetch_or(1U << kind, std::memory_order_relaxed);
}

std::optional<std::string> LiveExercise::take_end() {
  const std::scoped_lock lock(told_);
  return std::exchange(end_, std::nullopt);
}

void LiveExercise::stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

}  // namespace beatlas::viewer
