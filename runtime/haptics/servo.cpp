#include "runtime/haptics/servo.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::haptics {
namespace {

std::unique_ptr<Scene> checked(Scene scene) {
  if (!scene.model) throw_invalid("a servo needs a scene with a force model");
  if (!(scene.period_s > 0) || !std::isfinite(scene.period_s)) {
    throw_invalid("a scene's period must be a positive number of seconds");
  }
  return std::make_unique<Scene>(std::move(scene));
}

std::array<double, 3> numbers(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

// Bit by bit: -0 is not 0, and a NaN is itself.
template <class T>
bool same_bits(const T& a, const T& b) {
  using Words = std::array<std::uint64_t, sizeof(T) / sizeof(std::uint64_t)>;
  return std::bit_cast<Words>(a) == std::bit_cast<Words>(b);
}

}  // namespace

Servo::Servo(Scene scene, const ServoOptions& options)
    : scene_(checked(std::move(scene))),
      heart_(scene_->period_s, options.heart),
      safety_(options.safety),
      recorder_(options.recorded_ticks),
      rate_hz_(heart_.first_wish().rate_hz) {}

void Servo::restart() noexcept {
  stopped_.store(false, std::memory_order_relaxed);
  restarts_.fetch_add(1, std::memory_order_release);
}

void Servo::offer(Scene scene) { scenes_.offer(checked(std::move(scene))); }

bool Servo::take_up_offer() noexcept {
  bool goes_on = false;
  const auto carry = [&goes_on](const Scene& before, Scene& fresh) noexcept {
    goes_on = fresh.period_s == before.period_s && fresh.model->take_over(*before.model);
  };
  if (!scenes_.take_up(scene_, carry)) return false;
  heart_.set_period(scene_->period_s);
  ++scene_number_;
  return !goes_on;
}

Tick Servo::run(const ServoState& state, const HeartWish& wish) noexcept {
  Tick tick;
  const bool valid = state.valid && state.position_mm.allFinite() && std::isfinite(state.time_s) &&
                     state.orientation.coeffs().allFinite();
  if (valid) {
    const double elapsed_s = ran_ ? std::max(0.0, state.time_s - last_time_s_) : 0;
    heart_.advance(elapsed_s, wish);
    last_time_s_ = state.time_s;
    ran_ = true;
    tick.contact = scene_->model->evaluate(
        state,
        {.elapsed_s = elapsed_s, .field_time_s = heart_.field_time_s(), .speed = heart_.speed()});
  }
  const SafeForce safe =
      safety_.apply(tick.contact.force_n, tick.contact.depth_mm, state.time_s, valid);
  if (safe.status == TickStatus::Fault) scene_->model->reset();
  tick.status = safe.status;
  tick.force_n = safe.force_n;
  return tick;
}

Tick Servo::tick(const ServoState& state) noexcept {
  const bool swapped = take_up_offer();
  const std::uint32_t restarts = restarts_.load(std::memory_order_acquire);
  const HeartWish wish{.rate_hz = rate_hz_.load(std::memory_order_relaxed),
                       .paused = paused_.load(std::memory_order_relaxed),
                       .hold_phase = hold_phase_.load(std::memory_order_relaxed)};
  TickRecord record;
  record.stopped = stopped_.load(std::memory_order_relaxed);
  record.restarted = restarts != restarts_seen_;
  if (record.restarted) {
    restarts_seen_ = restarts;
    safety_.restart();
    scene_->model->reset();
  }
  if (record.stopped) safety_.stop();
  record.before = memory();
  ServoState seen = state;
  if (swapped) seen.valid = false;  // this tick is a fault: zero force, then the ramp
  Tick tick = run(seen, wish);

  record.time_s = seen.time_s;
  record.position_mm = numbers(seen.position_mm);
  const auto& q = seen.orientation.coeffs();
  record.orientation = {q[0], q[1], q[2], q[3]};
  record.valid = seen.valid;
  record.scene = scene_number_;
  record.wish = wish;
  record.status = tick.status;
  record.force_n = numbers(tick.force_n);
  record.model_force_n = numbers(tick.contact.force_n);
  record.distance_mm = tick.contact.distance_mm;
  recorder_.record(record);

  Published out;
  out.ticks = ++ticks_;
  out.time_s = seen.time_s;
  out.phase = heart_.phase();
  out.rate_hz = heart_.rate_hz();
  out.position_mm = record.position_mm;
  out.orientation = record.orientation;
  out.proxy_mm = numbers(tick.contact.proxy_mm);
  out.normal = numbers(tick.contact.normal);
  out.force_n = record.force_n;
  out.distance_mm = tick.contact.distance_mm;
  out.status = tick.status;
  out.touching = tick.contact.touching;
  published_.write(out);
  return tick;
}

ServoMemory Servo::memory() const noexcept {
  return {.model = scene_->model->memory(),
          .heart = heart_.memory(),
          .safety = safety_.memory(),
          .last_time_s = last_time_s_,
          .ran = ran_ ? 1.0 : 0.0};
}

void Servo::restore(const ServoMemory& memory) noexcept {
  scene_->model->restore(memory.model);
  heart_.restore(memory.heart);
  safety_.restore(memory.safety);
  last_time_s_ = memory.last_time_s;
  ran_ = memory.ran != 0;
}

Tick Servo::replay(const TickRecord& record) noexcept {
  restore(record.before);
  const auto& x = record.position_mm;
  const auto& q = record.orientation;
  return run({.time_s = record.time_s,
              .position_mm = Vec3(x[0], x[1], x[2]),
              .valid = record.valid,
              .orientation = Eigen::Quaterniond(q[3], q[0], q[1], q[2])},
             record.wish);
}

ReplayReport replay_ticks(Servo& servo, const std::vector<TickRecord>& ticks, std::uint32_t scene) {
  ReplayReport report;
  for (std::size_t n = 0; n < ticks.size(); ++n) {
    const TickRecord& record = ticks[n];
    if (record.scene != scene) continue;
    const Tick tick = servo.replay(record);
    ++report.ticks;
    bool same = tick.status == record.status && same_bits(numbers(tick.force_n), record.force_n) &&
                same_bits(numbers(tick.contact.force_n), record.model_force_n) &&
                same_bits(tick.contact.distance_mm, record.distance_mm);
    // What it leaves is what the next tick found, if nobody came in between.
    if (n + 1 < ticks.size() && ticks[n + 1].scene == scene && !ticks[n + 1].restarted &&
        !ticks[n + 1].stopped) {
      same = same && same_bits(servo.memory(), ticks[n + 1].before);
    }
    if (same) continue;
    if (report.different++ == 0) report.first_different = n;
  }
  return report;
}

}  // namespace beatlas::haptics
