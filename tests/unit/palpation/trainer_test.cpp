#include "runtime/palpation/trainer.h"

#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::palpation {
namespace {

constexpr double kTick = 1e-3;
constexpr int kMiddleAnterior = 7;

struct Felt {
  double diastole_n = 0;  // at the last end of a beat
  double systole_n = 0;   // at the last peak of contraction
  double diastole_depth_m = 0;
  double systole_depth_m = 0;
};

// A finger held for some seconds.
Felt held(Trainer& trainer, const std::vector<Finger>& fingers, double seconds = 6) {
  Felt felt;
  double strongest = 0;
  std::uint64_t beat = trainer.signals().beats;
  for (int n = 0; n < seconds / kTick; ++n) {
    const double force = trainer.tick(kTick, fingers)[0];
    const Signals& now = trainer.signals();
    if (now.beats != beat) {
      beat = now.beats;
      strongest = 0;
      felt.diastole_n = force;
      felt.diastole_depth_m = now.depth_m[0];
    }
    if (now.elastance_mmhg_per_ml > strongest) {
      strongest = now.elastance_mmhg_per_ml;
      felt.systole_n = force;
      felt.systole_depth_m = now.depth_m[0];
    }
  }
  return felt;
}

Felt held(const PalpationParameters& parameters, const Finger& finger) {
  Trainer trainer(parameters, 1);
  return held(trainer, {finger});
}

const Finger kPress{.place_mm = Vec3::Zero(), .depth_m = 0.008, .long_axis = 0.5, .segment = 7};

TEST(Trainer, WithoutAFingerBeatsAsTheCirculationDoes) {
  Trainer trainer({}, 1);
  const std::vector<Finger> none;
  for (int n = 0; n < 3000; ++n) EXPECT_EQ(trainer.tick(kTick, none)[0], 0);
  EXPECT_NEAR(trainer.signals().beat.output_l_per_min, 2.24, 0.02);
  EXPECT_NEAR(trainer.signals().natural_output_l_per_min, 2.24, 0.02);
  EXPECT_EQ(trainer.published().ticks, 3000U);
}

TEST(Trainer, APressLowersTheOutputAndIsFelt) {
  Trainer trainer({}, 1);
  const Felt felt = held(trainer, {kPress}, 20);
  const Signals& now = trainer.signals();
  EXPECT_NEAR(now.beat.output_l_per_min / now.natural_output_l_per_min, 0.74, 0.03);
  // At end-diastole the wall is where it was, less the dent: the finger is as deep as it stands.
  EXPECT_NEAR(felt.diastole_depth_m, 0.008, 0.0005);
  EXPECT_LT(felt.systole_depth_m, 0.007);
  EXPECT_GT(felt.diastole_n, 0.2);
  EXPECT_LT(felt.diastole_n, 1.0);
  // The picture is dented to the finger.
  EXPECT_NEAR(now.dent_m[0], now.depth_m[0], 1e-12);
}

TEST(Trainer, TheSumOfVolumesIsTheVentricles) {
  // Equation (1) less the dent: V = V_ref + S0 x_wall - S_c (D + x_wall).
  Trainer trainer({}, 1);
  for (int n = 0; n < 4000; ++n) {
    trainer.tick(kTick, std::vector<Finger>{kPress});
    const Signals& now = trainer.signals();
    const double dent_m = std::max(0.0, 0.008 + now.wall_m);
    const double volume_ml = 49.9 + 100 * (side_area_cm2(49.9) * now.wall_m - 14.1 * dent_m);
    ASSERT_NEAR(now.volume_ml, volume_ml, 1e-9);
  }
}

TEST(Trainer, TheHorizontalMuscleContractsAndLetsGoWithoutAJump) {
  Trainer trainer({}, 1);
  const std::vector<Finger> above{Finger{.depth_m = -0.01, .long_axis = 0.5, .segment = 7}};
  double last = 0;
  double largest = 0;
  int contracting = 0;
  for (int n = 0; n < 3000; ++n) {
    trainer.tick(kTick, above);
    const Signals& now = trainer.signals();
    if (trainer.circulation().contracting()) {  // k_h2 and the contractile element hold it
      const double contractile =
          PalpationParameters{}.contractile.stiffness_n_per_m(1, now.elastance_mmhg_per_ml);
      EXPECT_NEAR(now.muscle_n[0], -(709.6 + contractile) * now.wall_m, 1e-12);
      ++contracting;
    }
    // Where the beat begins the branch's spring hands over; it has let go by then.
    if (n > 0) largest = std::max(largest, std::abs(now.muscle_n[0] - last));
    last = now.muscle_n[0];
  }
  EXPECT_GT(contracting, 1000);
  EXPECT_LT(contracting, 2000);
  EXPECT_LT(largest, 0.1);
}

TEST(Trainer, SeveralFingersShareOneDent) {
  const auto forces = [](double apart_mm) {
    Trainer trainer({}, 2);
    Finger second = kPress;
    second.place_mm.x() = apart_mm;
    for (int n = 0; n < 4000; ++n) trainer.tick(kTick, std::vector<Finger>{kPress, second});
    const Signals& now = trainer.signals();
    return std::pair{now.force_n[0] + now.force_n[1], now.beat.output_l_per_min};
  };
  Trainer alone({}, 1);
  for (int n = 0; n < 4000; ++n) alone.tick(kTick, std::vector<Finger>{kPress});
  const double one_n = alone.signals().force_n[0];
  const auto [close_n, close_out] = forces(0);
  const auto [far_n, far_out] = forces(500);
  // Two fingers at one place are one finger on one patch; far apart they are two.
  EXPECT_NEAR(close_out, alone.signals().beat.output_l_per_min, 0.01);
  EXPECT_NEAR(close_n, one_n, 0.25 * one_n);
  EXPECT_GT(far_n, 1.5 * one_n);
  EXPECT_LT(far_out, 0.9 * close_out);
}

TEST(Trainer, DiseasedTissueIsToldApartByForce) {
  // In steps that a finger can just tell apart; more than one is felt.
  const Felt healthy = held({}, kPress);
  const Felt infarct = held(palpation_preset("anterior_infarct"), kPress);
  const Felt dilated = held(palpation_preset("dilated_cardiomyopathy"), kPress);
  Finger beside = kPress;
  beside.segment = 10;  // the inferior wall of the same heart
  const Felt remote = held(palpation_preset("anterior_infarct"), beside);
  EXPECT_GT(force_jnds(infarct.diastole_n, healthy.diastole_n), 3);
  EXPECT_GT(force_jnds(infarct.diastole_n, remote.diastole_n), 3);
  EXPECT_GT(force_jnds(infarct.systole_n, remote.systole_n), 3);
  EXPECT_GT(force_jnds(dilated.diastole_n, healthy.diastole_n), 1);
  EXPECT_LT(infarct.diastole_n, healthy.diastole_n);  // softer, as paper B lets it be felt
  EXPECT_EQ(force_jnds(0.5, 0.5), 0);
  EXPECT_NEAR(force_jnds(2.14, 2), 1, 1e-12);
  EXPECT_NEAR(force_jnds(0.149, 0.1), 1, 1e-12);
}

TEST(Trainer, ContractionIsFeltAndGoesWithAlpha) {
  // As deep in the moving wall at both times, so the patch's own stiffness is what differs.
  PalpationParameters still;
  for (Tissue& tissue : still.segments) tissue.alpha = 0;
  EXPECT_NEAR((75 + still.contractile.stiffness_n_per_m(1, 4.5)) /
                  (75 + still.contractile.stiffness_n_per_m(1, 0.19)),
              1.72, 0.01);
  const Felt healthy = held({}, kPress);
  PalpationParameters one;
  one.segments[kMiddleAnterior - 1].alpha = 0.3;
  const Felt weak = held(one, kPress);
  EXPECT_LT(weak.systole_n, 0.95 * healthy.systole_n);
}

TEST(Trainer, WishesAreTakenUpWhileItRuns) {
  Trainer trainer({}, 1);
  const std::vector<Finger> none;
  PalpationParameters wish;
  wish.circulation.left_atrial_mmhg = 4;
  wish.circulation.heart_rate_per_min = 80;
  trainer.wish(wish);
  double last = trainer.circulation().lv_mmhg();
  double largest = 0;
  for (int n = 0; n < 20000; ++n) {
    trainer.tick(kTick, none);
    largest = std::max(largest, std::abs(trainer.signals().lv_mmhg - last));
    last = trainer.signals().lv_mmhg;
  }
  EXPECT_EQ(trainer.signals().left_atrial_mmhg, 4);
  EXPECT_EQ(trainer.signals().heart_rate_per_min, 80);
  EXPECT_LT(trainer.signals().beat.output_l_per_min, 1.6);
  EXPECT_LT(largest, 4);  // no jump: what the steepest rise of the pressure does in a tick
  wish.circulation.emin = 100;
  EXPECT_THROW(trainer.wish(wish), Error);
  EXPECT_THROW(Trainer({}, 0), Error);
  EXPECT_THROW(Trainer({}, 9), Error);
}

TEST(Trainer, HoldsAMeanAorticPressureIfWished) {
  PalpationParameters parameters;
  parameters.aortic_target_mmhg = 80;
  Trainer trainer(parameters, 1);
  const std::vector<Finger> none;
  for (int n = 0; n < 40000; ++n) trainer.tick(kTick, none);
  EXPECT_NEAR(trainer.signals().beat.aortic_mean_mmhg, 80, 0.5);
}

TEST(Trainer, AnotherThreadMayWishAndLook) {
  // Read by the thread sanitizer.
  Trainer trainer({}, 2);
  std::atomic<bool> done{false};
  std::thread ticking([&] {
    const std::vector<Finger> fingers{kPress, kPress};
    for (int n = 0; n < 5000 || !done; ++n) trainer.tick(kTick, fingers);
  });
  bool torn = false;
  for (int n = 0; n < 2000; ++n) {
    PalpationParameters wish;
    wish.circulation.left_atrial_mmhg = 3 + n % 10;
    wish.segments[0].alpha = 0.1 * (n % 10);
    trainer.wish(wish);
    const Signals seen = trainer.published();
    // A torn value is a whole tick off; the sum of the steps rounds off by 1e-6 in 1e7 of them.
    torn = torn || std::abs(seen.time_s - kTick * static_cast<double>(seen.ticks)) > 0.5 * kTick;
    std::this_thread::yield();
  }
  done = true;
  ticking.join();
  EXPECT_FALSE(torn);
}

TEST(Trainer, HardCase14TheBeatingWallsWorkIsAccountedFor) {
  // A finger on a wall that beats under it, 100 beats: work at the finger and work of the wall go
  // into the patch and are stored or lost there; a contraction that stiffens it adds its own.
  VerticalPatch patch({});
  const ElastanceCurve curve(60.0 / 110, 32.4);
  const Contractile contractile;
  double finger_j = 0;
  double wall_j = 0;
  double muscle_j = 0;
  double lost_j = 0;
  double depth = 0;
  double wall = 0;
  double force = 0;
  double dent = 0;
  double before_k = 75;
  const double h = 2.5e-4;
  const int ticks = static_cast<int>(100 * 60.0 / 110 / h);
  for (int n = 1; n <= ticks; ++n) {
    const double t = n * h;
    const double e = curve.at(std::fmod(t, 60.0 / 110)).value;
    const double next_wall = -0.0035 * e;
    const double next_depth = 0.003 * (1 - std::cos(2 * M_PI * 1.5 * t));
    const double k = 75 + contractile.stiffness_n_per_m(1, 0.19 + 4.31 * e);
    const auto spring = [](double stiffness) { return stiffness * 800 / (800 - stiffness); };
    muscle_j += 0.5 * (spring(k) - spring(before_k)) * dent * dent;
    before_k = k;
    const double next_force = patch.advance(next_depth + next_wall, k, h);
    const double mean = 0.5 * (force + next_force);
    finger_j += mean * (next_depth - depth);
    wall_j += mean * (next_wall - wall);
    const double rate = (patch.dent_m() - dent) / h;
    lost_j += 60 * spring(k) / k * rate * rate * h;
    depth = next_depth;
    wall = next_wall;
    force = next_force;
    dent = patch.dent_m();
  }
  const double given = finger_j + wall_j + muscle_j;
  EXPECT_GT(lost_j, 0.01);
  EXPECT_NEAR(given, lost_j + patch.energy_j(), 0.01 * lost_j);
  EXPECT_GT(std::abs(wall_j), 0.1 * std::abs(finger_j));  // the wall is no bystander
}

}  // namespace
}  // namespace beatlas::palpation
