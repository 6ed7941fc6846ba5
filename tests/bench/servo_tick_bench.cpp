// Full ticks on a moving field: model, safety stage, recorder, publication. Thread CPU time of
// every single tick; p50, p99, p99.9 and the largest are counters [us], the clock's own cost
// (clock_us) taken off. Read ratios within one run.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <map>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "runtime/haptics/proxy.h"
#include "runtime/haptics/servo.h"
#include "runtime/haptics/shell.h"
#include "runtime/haptics/taxels.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas {
namespace {

constexpr double kPeriod = 0.75;

double radius(double t) { return 36 + 3 * std::sin(2 * std::numbers::pi * t / kPeriod); }

// A beating sphere as large as a ventricle, at 1.5 mm.
std::shared_ptr<const field::FieldQuery> sphere(int phases = 15) {
  static std::map<int, std::shared_ptr<const field::FieldQuery>> made;
  auto& query = made[phases];
  if (!query) {
    query = std::make_shared<const field::FieldQuery>(
        testing::dense_payload(
            {.origin_mm = Vec3::Constant(-48), .blocks = {8, 8, 8}, .phases = phases},
            [](const Vec3& x, double t) { return x.norm() - radius(t); }),
        kPeriod);
  }
  return query;
}

// The same as a package holds it: no leaf farther than `band_mm` from where the surface ever is.
std::shared_ptr<const field::FieldQuery> banded_sphere(double band_mm) {
  constexpr double kBlockMm = 8 * 1.5;
  const atlas::FieldPayload& dense = sphere()->payload();
  auto payload = std::make_shared<atlas::FieldPayload>(dense);
  const std::size_t leaf = dense.coefficients.size() / dense.leaf_count();
  payload->coefficients.clear();
  payload->inner_mm = payload->outer_mm = band_mm;
  std::int32_t leaves = 0;
  std::size_t n = 0;
  for (int z = 0; z < dense.block_count[2]; ++z) {
    for (int y = 0; y < dense.block_count[1]; ++y) {
      for (int x = 0; x < dense.block_count[0]; ++x, ++n) {
        const Vec3 middle = dense.origin_mm + kBlockMm * Vec3(x + 0.5, y + 0.5, z + 0.5);
        const double near_mm = std::abs(middle.norm() - 36) - 3 - 0.5 * kBlockMm * std::sqrt(3.0);
        if (near_mm > band_mm) {
          payload->blocks[n] =
              middle.norm() < 36 ? atlas::FieldPayload::kInside : atlas::FieldPayload::kOutside;
          continue;
        }
        const auto from =
            dense.coefficients.begin() + static_cast<std::ptrdiff_t>(leaf) * dense.blocks[n];
        payload->coefficients.insert(payload->coefficients.end(), from,
                                     from + static_cast<std::ptrdiff_t>(leaf));
        payload->blocks[n] = leaves++;
      }
    }
  }
  return std::make_shared<const field::FieldQuery>(payload, kPeriod);
}

double thread_cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

double at_share(std::vector<double>& sorted, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

void report(benchmark::State& state, std::vector<double>& times_us) {
  std::vector<double> clock_us;
  for (int n = 0; n < 10000; ++n) {
    const double begin = thread_cpu_us();
    clock_us.push_back(thread_cpu_us() - begin);
  }
  std::sort(clock_us.begin(), clock_us.end());
  std::sort(times_us.begin(), times_us.end());
  const double clock = at_share(clock_us, 0.5);
  state.counters["clock_us"] = clock;
  double sum_us = 0;
  for (const double each_us : times_us) sum_us += each_us - clock;
  const double mean_us = sum_us / static_cast<double>(times_us.size());
  state.counters["mean_us"] = mean_us;
  state.counters["core_at_10kHz_%"] = mean_us;  // 1 us of 100
  state.counters["p50_us"] = at_share(times_us, 0.5) - clock;
  state.counters["p99_us"] = at_share(times_us, 0.99) - clock;
  state.counters["p99.9_us"] = at_share(times_us, 0.999) - clock;
  state.counters["max_us"] = times_us.back() - clock;
}

// A finger that slides over the surface at about 80 mm/s, `depth_mm` under it.
Vec3 sliding(double t, double outside_mm, double depth_mm) {
  const double theta = std::numbers::pi * (0.5 + 0.35 * std::sin(0.37 * t));
  const double phi = 2 * std::numbers::pi * 0.35 * t;
  return (radius(t) + outside_mm - depth_mm) *
         Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
}

void tick_many(benchmark::State& state, haptics::Scene scene, double outside_mm, double depth_mm) {
  haptics::Servo servo(std::move(scene), {.safety = {}, .heart = {}, .recorded_ticks = 10000});
  std::vector<double> times_us;
  times_us.reserve(1U << 22U);
  double t = 0;
  for (auto _ : state) {
    t += 0.001;
    const haptics::ServoState at{.time_s = t, .position_mm = sliding(t, outside_mm, depth_mm)};
    const double begin = thread_cpu_us();
    benchmark::DoNotOptimize(servo.tick(at));
    const double end = thread_cpu_us();
    if (times_us.size() < times_us.capacity()) times_us.push_back(end - begin);
  }
  report(state, times_us);
}

// range(0): radius [mm]; range(1): depth [mm], below 0 outside.
void full_tick_proxy(benchmark::State& state) {
  const auto radius_mm = static_cast<double>(state.range(0));
  const auto field = std::make_shared<const haptics::AtlasField>(sphere());
  haptics::Scene scene{.model = std::make_unique<haptics::ProxyModel>(
                           field, haptics::ProxyOptions{.radius_mm = radius_mm}),
                       .period_s = kPeriod};
  tick_many(state, std::move(scene), radius_mm, static_cast<double>(state.range(1)));
}
BENCHMARK(full_tick_proxy)->Args({3, 3})->Args({0, 3})->Args({3, -5})->MinTime(2);

haptics::Scene three_mm_sphere(std::shared_ptr<const field::FieldQuery> field,
                               double half_length_mm = 0) {
  return {.model = std::make_unique<haptics::ProxyModel>(
              std::make_shared<const haptics::AtlasField>(std::move(field)),
              haptics::ProxyOptions{.radius_mm = 3, .half_length_mm = half_length_mm}),
          .period_s = kPeriod};
}

// Scaling. range(0): phases of the cycle.
void full_tick_of_phases(benchmark::State& state) {
  const auto field = sphere(static_cast<int>(state.range(0)));
  state.counters["MB"] = 2e-6 * static_cast<double>(field->payload().coefficients.size());
  tick_many(state, three_mm_sphere(field), 3, 3);
}
BENCHMARK(full_tick_of_phases)->Arg(5)->Arg(15)->Arg(30)->Arg(60)->MinTime(1);

// range(0): how far from the surface leaves are kept [mm].
void full_tick_of_band(benchmark::State& state) {
  const auto field = banded_sphere(static_cast<double>(state.range(0)));
  state.counters["MB"] = 2e-6 * static_cast<double>(field->payload().coefficients.size());
  tick_many(state, three_mm_sphere(field), 3, 3);
}
BENCHMARK(full_tick_of_band)->Arg(6)->Arg(12)->Arg(24)->Arg(48)->MinTime(1);

// range(0): half the length of a capsule of 3 mm radius [mm].
void full_tick_capsule(benchmark::State& state) {
  tick_many(state, three_mm_sphere(sphere(), static_cast<double>(state.range(0))), 3, 3);
}
BENCHMARK(full_tick_capsule)->Arg(5)->Arg(20)->MinTime(1);

// The servo's thread on its own timer 10 000 times a second, sleeping in between: what the tick
// takes of a core, and the whole thread with its wake-ups.
void paced_at_10_khz(benchmark::State& state) {
  haptics::Servo servo(three_mm_sphere(sphere()),
                       {.safety = {}, .heart = {}, .recorded_ticks = 10000});
  double ticks_us = 0;
  double all_us = 0;
  int ticks = 0;
  for (auto _ : state) {
    timespec due{};
    clock_gettime(CLOCK_MONOTONIC, &due);
    const double thread_begin = thread_cpu_us();
    for (int n = 0; n < 20000; ++n) {
      due.tv_nsec += 100000;
      if (due.tv_nsec >= 1000000000) {
        due.tv_nsec -= 1000000000;
        ++due.tv_sec;
      }
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
      const double t = 1e-4 * ++ticks;
      const haptics::ServoState at{.time_s = t, .position_mm = sliding(t, 3, 3)};
      const double begin = thread_cpu_us();
      benchmark::DoNotOptimize(servo.tick(at));
      ticks_us += thread_cpu_us() - begin;
    }
    all_us += thread_cpu_us() - thread_begin;
  }
  state.counters["tick_%"] = ticks_us / ticks;  // 1 us of 100
  state.counters["thread_%"] = all_us / ticks;
}
BENCHMARK(paced_at_10_khz)->Iterations(1)->UseRealTime()->Unit(benchmark::kSecond);

void full_tick_two_step(benchmark::State& state) {
  haptics::Scene scene{
      .model = std::make_unique<haptics::TwoStepModel>(sphere(), haptics::TwoStepOptions{}),
      .period_s = kPeriod};
  tick_many(state, std::move(scene), 0, 3);
}
BENCHMARK(full_tick_two_step)->MinTime(2);

// range(0): points; range(1): depth [mm]. An 8 mm fingertip that points into the body.
void full_tick_fingertip(benchmark::State& state) {
  const auto points = static_cast<std::size_t>(state.range(0));
  const auto depth_mm = static_cast<double>(state.range(1));
  const auto field = std::make_shared<const haptics::AtlasField>(sphere());
  auto model = std::make_unique<haptics::ShellModel>(field, haptics::fingertip(8, points),
                                                     haptics::ShellOptions{});
  const haptics::ShellModel* const shell = model.get();
  haptics::Servo servo({.model = std::move(model), .period_s = kPeriod},
                       {.safety = {}, .heart = {}, .recorded_ticks = 10000});
  std::vector<double> times_us;
  double t = 0;
  double samples = 0;
  for (auto _ : state) {
    t += 0.001;
    const Vec3 x = sliding(t, 8, depth_mm);
    const haptics::ServoState at{
        .time_s = t,
        .position_mm = x,
        .orientation = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), x)};
    const double begin = thread_cpu_us();
    benchmark::DoNotOptimize(servo.tick(at));
    const double end = thread_cpu_us();
    times_us.push_back(end - begin);
    samples += static_cast<double>(shell->samples());
  }
  state.counters["samples"] = samples / static_cast<double>(times_us.size());
  report(state, times_us);
}
BENCHMARK(full_tick_fingertip)
    ->Args({10000, 2})
    ->Args({10000, 8})
    ->Args({5000, 8})
    ->Args({2000, 8})
    ->Args({1000, 8})
    ->Args({300, 8})
    ->Args({100, 8})
    ->MinTime(2)
    ->Unit(benchmark::kMicrosecond);

// An 8 mm ball, 2 mm deep: 81 places of the field and 64 taxels.
void taxels_under_a_ball(benchmark::State& state) {
  haptics::Taxels taxels(std::make_shared<const haptics::AtlasField>(sphere()), {.radius_mm = 8});
  std::vector<double> times_us;
  double t = 0;
  for (auto _ : state) {
    t += 0.001;
    const Vec3 out = sliding(t, 8, 0).normalized();
    const haptics::BallContact contact{
        .proxy_mm = (radius(t) + 8) * out, .normal = out, .force_n = 0.3 * out, .depth_mm = 2};
    const double begin = thread_cpu_us();
    benchmark::DoNotOptimize(taxels.under(contact, t));
    const double end = thread_cpu_us();
    times_us.push_back(end - begin);
  }
  report(state, times_us);
}
BENCHMARK(taxels_under_a_ball)->MinTime(2)->Unit(benchmark::kMicrosecond);

// range(0): points of an 8 mm fingertip, 2 mm deep. The map alone, without the tick.
void taxels_under_a_fingertip(benchmark::State& state) {
  haptics::ShellModel model(std::make_shared<const haptics::AtlasField>(sphere()),
                            haptics::fingertip(8, static_cast<std::size_t>(state.range(0))), {});
  std::vector<double> times_us;
  double t = 0;
  for (auto _ : state) {
    t += 0.001;
    const Vec3 x = sliding(t, 8, 2);
    (void)model.evaluate(
        {.position_mm = x, .orientation = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), x)},
        {.field_time_s = t});
    const double begin = thread_cpu_us();
    benchmark::DoNotOptimize(model.taxels(Vec3::UnitX()));
    const double end = thread_cpu_us();
    times_us.push_back(end - begin);
  }
  report(state, times_us);
}
BENCHMARK(taxels_under_a_fingertip)
    ->Arg(2000)
    ->Arg(10000)
    ->MinTime(2)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace beatlas
