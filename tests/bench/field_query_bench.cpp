#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>
#include <time.h>

#include "runtime/field/field_query.h"
#include "runtime/field/shell_query.h"
#include "runtime/haptics/servo.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas {
namespace {

constexpr double kPeriod = 0.75;

// A beating sphere of 36 +- 3 mm at 1.5 mm and 15 phases, as large as a ventricle.
const std::shared_ptr<const field::FieldQuery>& sphere() {
  static const auto query = std::make_shared<const field::FieldQuery>(
      testing::dense_payload({.origin_mm = Vec3::Constant(-48), .blocks = {8, 8, 8}},
                             [](const Vec3& x, double t) {
                               return x.norm() - 36 -
                                      3 * std::sin(2 * std::numbers::pi * t / kPeriod);
                             }),
      kPeriod);
  return query;
}

// Along a path: 1 kHz ticks of a finger that wanders over the surface.
void sample_along_path(benchmark::State& state) {
  const field::FieldQuery& query = *sphere();
  std::vector<Vec3> path;
  for (int n = 0; n < 4096; ++n) {
    const double t = 0.001 * n;
    const double theta = std::numbers::pi * (0.5 + 0.35 * std::sin(0.37 * t));
    const double phi = 2 * std::numbers::pi * 0.35 * t;
    path.emplace_back(35 * Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                                std::cos(theta)));
  }
  std::size_t n = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(query.sample(path[n % path.size()], 0.001 * static_cast<double>(n)));
    ++n;
  }
}
BENCHMARK(sample_along_path);

void sample_at_random_points(benchmark::State& state) {
  const field::FieldQuery& query = *sphere();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-40, 40);
  std::vector<Vec3> points;
  for (int n = 0; n < 65536; ++n) points.emplace_back(u(random), u(random), u(random));
  std::size_t n = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        query.sample(points[n % points.size()], 0.011 * static_cast<double>(n)));
    ++n;
  }
}
BENCHMARK(sample_at_random_points);

// A fingertip of 8 mm radius that is pressed 3 mm into the sphere; its points at one time.
std::vector<Vec3> fingertip(int points) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  std::vector<Vec3> out;
  for (int n = 0; n < points; ++n) {
    const Vec3 direction(normal(random), normal(random), normal(random));
    out.emplace_back(Vec3(28, 22, 21) + 8 * direction.normalized());
  }
  return out;
}

void shell_one_by_one(benchmark::State& state) {
  const std::vector<Vec3> points = fingertip(static_cast<int>(state.range(0)));
  std::vector<field::FieldSample> found(points.size());
  double t = 0;
  for (auto _ : state) {
    t += 0.001;
    for (std::size_t n = 0; n < points.size(); ++n) found[n] = sphere()->sample(points[n], t);
    benchmark::DoNotOptimize(found.data());
  }
}
BENCHMARK(shell_one_by_one)->Arg(100)->Arg(1000)->Arg(10000)->Unit(benchmark::kMicrosecond);

void shell_at_once(benchmark::State& state) {
  const std::vector<Vec3> points = fingertip(static_cast<int>(state.range(0)));
  std::vector<field::FieldSample> found(points.size());
  field::ShellQuery shells(sphere());
  std::vector<double> taken_us;
  double t = 0;
  for (auto _ : state) {
    t += 0.001;
    timespec start{};
    timespec end{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &start);
    shells.sample(points, t, found);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    taken_us.push_back(1e6 * static_cast<double>(end.tv_sec - start.tv_sec) +
                       1e-3 * static_cast<double>(end.tv_nsec - start.tv_nsec));
    benchmark::DoNotOptimize(found.data());
  }
  std::sort(taken_us.begin(), taken_us.end());
  state.counters["p99.9_us"] = taken_us[taken_us.size() * 999 / 1000];
  state.counters["max_us"] = taken_us.back();
}
BENCHMARK(shell_at_once)
    ->Arg(100)
    ->Arg(1000)
    ->Arg(10000)
    ->MinTime(3)
    ->Unit(benchmark::kMicrosecond);

// Model and safety stage; range(0): 0 continuous, 1 published.
void servo_tick(benchmark::State& state) {
  haptics::TwoStepOptions options;
  if (state.range(0) == 1) options.time_mode = haptics::TimeMode::Published;
  haptics::Servo servo(haptics::two_step_scene(sphere(), options), {});
  double t = 0;
  for (auto _ : state) {
    t += 0.001;
    benchmark::DoNotOptimize(
        servo.tick({t, 35 * Vec3(std::sin(0.3 * t), std::cos(0.3 * t), 0), true}));
  }
}
BENCHMARK(servo_tick)->Arg(0)->Arg(1);

}  // namespace
}  // namespace beatlas
