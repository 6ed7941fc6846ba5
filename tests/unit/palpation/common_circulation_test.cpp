#include "runtime/palpation/common_circulation.h"

#include <algorithm>
#include <array>
#include <barrier>
#include <cmath>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/palpation/patch_model.h"
#include "tests/unit/palpation/plane_field.h"

namespace beatlas::palpation {
namespace {

constexpr double kTick = 1e-3;
constexpr double kPeriod = 60.0 / 110;  // of the parameters' own heart
constexpr double kMmPerM = 1e3;

/// x_natural of the parameters' own beat, evenly over it, as the images would show it.
std::vector<double> natural_motion_m(const PalpationParameters& parameters) {
  Trainer trainer(parameters, 1);
  std::vector<double> out;
  const int steps = 1000;
  while (trainer.signals().beats < 3) (void)trainer.tick(kPeriod / steps, {});
  for (int n = 0; n < steps; ++n) {
    out.push_back(trainer.signals().wall_m);
    (void)trainer.tick(kPeriod / steps, {});
  }
  return out;
}

/// It moves as the wall does without a finger.
class NaturalWallField final : public test::PlaneField {
 public:
  explicit NaturalWallField(std::vector<double> motion_m)
      : PlaneField(kPeriod), motion_m_(std::move(motion_m)) {}
  [[nodiscard]] haptics::FieldSample sample(const Vec3& x, double t) const noexcept override {
    const double along = (t / kPeriod - std::floor(t / kPeriod)) * double(motion_m_.size());
    const auto at = static_cast<std::size_t>(along) % motion_m_.size();
    const double after = motion_m_[(at + 1) % motion_m_.size()];
    const double wall_m = motion_m_[at] + (along - std::floor(along)) * (after - motion_m_[at]);
    return above(x, kMmPerM * wall_m, 0);
  }

 private:
  std::vector<double> motion_m_;
};

/// Fingers on the field, each with its own model, on one circulation; what each feels, tick by
/// tick, of the last second. @param depths_mm below the wall of end-diastole, for each finger
std::vector<std::vector<double>> felt_on_field(const std::vector<Vec3>& places_mm,
                                               const std::vector<double>& depths_mm,
                                               double seconds) {
  const PalpationParameters parameters;
  const auto field = std::make_shared<NaturalWallField>(natural_motion_m(parameters));
  const auto common = std::make_shared<CommonCirculation>(parameters, 0, std::size(places_mm));
  std::vector<std::unique_ptr<PatchModel>> models;
  for (std::size_t n = 0; n < places_mm.size(); ++n) {
    models.push_back(std::make_unique<PatchModel>(
        field, PatchModelOptions{.parameters = parameters, .circulation = common, .finger = n}));
  }
  std::vector<std::vector<double>> out(places_mm.size());
  const int ticks = static_cast<int>(seconds / kTick);
  for (int tick = 0; tick < ticks; ++tick) {
    const double t = kTick * tick;
    for (std::size_t n = 0; n < models.size(); ++n) {
      const Vec3 x = places_mm[n] - depths_mm[n] * Vec3::UnitZ();
      const haptics::Contact contact = models[n]->evaluate(
          {.time_s = t, .position_mm = x}, {.elapsed_s = tick == 0 ? 0 : kTick, .field_time_s = t});
      common->tell(n, places_mm[n], -contact.distance_mm / kMmPerM, t / kPeriod);
      if (tick >= ticks - 1000) out[n].push_back(contact.force_n.norm());
    }
    common->advance();
  }
  return out;
}

double largest(const std::vector<double>& all) { return *std::max_element(all.begin(), all.end()); }
double mean(const std::vector<double>& all) {
  double sum = 0;
  for (const double one : all) sum += one;
  return sum / static_cast<double>(all.size());
}

/// What the trainer itself, which has all fingers in one tick, has each feel.
std::vector<std::vector<double>> felt_in_trainer(const std::vector<Vec3>& places_mm,
                                                 const std::vector<double>& depths_mm,
                                                 double seconds) {
  Trainer trainer(PalpationParameters{}, places_mm.size());
  std::vector<Finger> fingers(places_mm.size());
  for (std::size_t n = 0; n < fingers.size(); ++n) {
    fingers[n].place_mm = places_mm[n];
    fingers[n].depth_m = depths_mm[n] / kMmPerM;
  }
  std::vector<std::vector<double>> out(places_mm.size());
  const int ticks = static_cast<int>(seconds / kTick);
  for (int tick = 0; tick < ticks; ++tick) {
    const auto forces = trainer.tick(kTick, fingers);
    for (std::size_t n = 0; tick >= ticks - 1000 && n < fingers.size(); ++n) {
      out[n].push_back(forces[n]);
    }
  }
  return out;
}

// The same fingers in one tick (trainer.h) and as servos of their own on a heart that moves as the
// natural beat does: the two ways must agree, alone, apart and near each other.
TEST(CommonCirculation, FingersWithServosOfTheirOwnFeelWhatTheTrainerTells) {
  struct Case {
    std::vector<Vec3> places_mm;
    std::vector<double> depths_mm;
  };
  const std::vector<Case> cases{{{Vec3(0, 0, 0)}, {8}},
                                {{Vec3(0, 0, 0), Vec3(200, 0, 0)}, {8, 6}},
                                {{Vec3(0, 0, 0), Vec3(12, 0, 0)}, {8, 6}}};
  for (const Case& fingers : cases) {
    const auto field = felt_on_field(fingers.places_mm, fingers.depths_mm, 8);
    const auto trainer = felt_in_trainer(fingers.places_mm, fingers.depths_mm, 8);
    for (std::size_t n = 0; n < field.size(); ++n) {
      EXPECT_NEAR(mean(field[n]), mean(trainer[n]), 0.03 * mean(trainer[n])) << n;
      EXPECT_NEAR(largest(field[n]), largest(trainer[n]), 0.05 * largest(trainer[n])) << n;
    }
  }
}

TEST(CommonCirculation, WhatOneFingerDisplacesAnotherFeels) {
  const auto beside = felt_on_field({Vec3::Zero(), Vec3(200, 0, 0)}, {6, -40}, 8);
  const auto pressed = felt_on_field({Vec3::Zero(), Vec3(200, 0, 0)}, {6, 10}, 8);
  EXPECT_EQ(largest(beside[1]), 0) << "it hovers";
  // 10 mm elsewhere displace 14 ml of 50: the wall comes towards the other finger.
  EXPECT_GT(std::abs(mean(pressed[0]) - mean(beside[0])), 0.02 * mean(beside[0]));
}

// Threads that tell and feel at once: nobody waits, and what is read is a whole.
TEST(CommonCirculation, ManyThreadsTakeItOnTogether) {
  constexpr std::size_t kFingers = 4;
  constexpr int kTicks = 20000;
  CommonCirculation common(PalpationParameters{}, 0, kFingers);
  const std::uint64_t before = common.published().beats;
  std::barrier together(kFingers);
  std::vector<std::jthread> threads;
  std::array<double, kFingers> worst{};
  for (std::size_t n = 0; n < kFingers; ++n) {
    threads.emplace_back([&, n] {
      for (int tick = 0; tick < kTicks; ++tick) {
        together.arrive_and_wait();
        common.tell(n, Vec3(100.0 * double(n), 0, 0), 0.004, kTick * tick / kPeriod);
        common.advance();
        const CommonCirculation::Felt felt = common.felt(n);
        worst[n] = std::max({worst[n], std::abs(felt.wall_m), felt.pressure_n_per_m / 1e3});
      }
    });
  }
  threads.clear();
  const Signals now = common.published();
  // One of them leads, and its heart has beaten so often.
  EXPECT_NEAR(double(now.beats - before), kTick * kTicks / kPeriod, 3);
  EXPECT_EQ(now.fingers, kFingers);
  for (const double one : worst) {
    EXPECT_GT(one, 0);
    EXPECT_LT(one, 0.2);
  }
}

TEST(CommonCirculation, AFingerThatIsLiftedIsFeltNoMore) {
  const PalpationParameters parameters;
  CommonCirculation common(parameters, 0, 2);
  double t = 0;
  const auto beat_on = [&](double seconds, double depth_m) {
    for (int n = 0; n < seconds / kTick; ++n, t += kTick) {
      common.tell(0, Vec3::Zero(), depth_m, t / kPeriod);
      common.advance();
    }
  };
  beat_on(4, 0.01);
  const double pressed = common.published().beat.output_l_per_min;
  EXPECT_LT(pressed, 0.9 * common.published().natural_output_l_per_min);
  common.lift(0);
  beat_on(6, -1);
  EXPECT_NEAR(common.published().beat.output_l_per_min, common.published().natural_output_l_per_min,
              0.01 * common.published().natural_output_l_per_min);
  EXPECT_THROW(CommonCirculation(parameters, 0, 9), Error);
}

}  // namespace
}  // namespace beatlas::palpation
