// An hour at 1 kHz, in accelerated time: nothing drifts, nothing grows, nothing is no number.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <memory>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "runtime/haptics/proxy.h"
#include "runtime/haptics/servo.h"
#include "tests/realtime/allocations.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas {
namespace {

constexpr double kPeriod = 0.75;
constexpr int kTicksABeat = 750;
constexpr int kBeats = 4800;  // an hour

/// Of the program's own memory: pages of files come and go with the code that happens to run,
/// sixteen at a time.
std::size_t resident_pages() {
  std::ifstream file("/proc/self/statm");
  std::size_t size = 0;
  std::size_t resident = 0;
  std::size_t of_files = 0;
  file >> size >> resident >> of_files;
  return resident - of_files;
}

TEST(Soak, AnHourOfBeatsEndsAsItBegan) {
  const auto query = std::make_shared<const field::FieldQuery>(
      testing::dense_payload(
          {.origin_mm = Vec3::Constant(-20), .blocks = {4, 4, 4}, .inner_mm = 8, .outer_mm = 6},
          [](const Vec3& x, double t) {
            return x.norm() - 13 - 2 * std::sin(2 * std::numbers::pi * t / kPeriod);
          }),
      kPeriod);
  haptics::Servo servo({.model = std::make_unique<haptics::ProxyModel>(
                            std::make_shared<haptics::AtlasField>(query),
                            haptics::ProxyOptions{.radius_mm = 1,
                                                  .damping_n_s_per_m = 2,
                                                  .friction_static = 0.4,
                                                  .friction_dynamic = 0.3}),
                        .period_s = kPeriod},
                       {.safety = {}, .heart = {}, .recorded_ticks = 10000});
  // A palpating hand whose path repeats with the beat: every beat must feel the same.
  std::vector<Vec3> first(kTicksABeat);
  double worst_n = 0;
  testing::allocations = 0;
  bool finite = true;
  std::size_t pages = 0;
  for (int beat = 0; beat < kBeats; ++beat) {
    for (int n = 0; n < kTicksABeat; ++n) {
      const double s = 2 * std::numbers::pi * n / kTicksABeat;
      const Vec3 x(13.5 + 2.5 * std::sin(2 * s), 2 * std::sin(s), 2 * std::cos(3 * s));
      const double t = 0.001 * (static_cast<double>(beat) * kTicksABeat + n);
      testing::counting = true;
      const haptics::Tick tick = servo.tick({.time_s = t, .position_mm = x});
      testing::counting = false;
      finite = finite && tick.force_n.allFinite() && tick.status != haptics::TickStatus::Fault;
      const Vec3& force = tick.contact.force_n;
      if (beat == 2) first[static_cast<std::size_t>(n)] = force;  // after the start
      if (beat > 2) {
        worst_n = std::max(worst_n, (force - first[static_cast<std::size_t>(n)]).norm());
      }
    }
    if (beat == 20) pages = resident_pages();
  }
  std::cout << "forces of an hour's beats differ by " << worst_n << " N at most, memory by "
            << static_cast<long>(resident_pages()) - static_cast<long>(pages) << " pages\n";
  EXPECT_TRUE(finite);
  EXPECT_EQ(testing::allocations, 0);
  // Time is a sum of rounded ticks: after an hour the phase is some 1e-10 off, no more.
  EXPECT_LE(worst_n, 1e-6);
  EXPECT_LE(resident_pages(), pages + 16);  // a byte a tick would be 880
  EXPECT_EQ(servo.published().ticks, static_cast<std::uint64_t>(kBeats) * kTicksABeat);
}

}  // namespace
}  // namespace beatlas
