#include "runtime/palpation/trainer.h"

#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/palpation/fit.h"

namespace beatlas::palpation {
namespace {

constexpr double kTick = 1e-3;
constexpr int kMiddleAnterior = 7;

struct Felt {
  double diastole_n = 0;  // at the last end of a beat
  double systole_n = 0;   // at the peak of contraction of the last whole beat
  double diastole_depth_m = 0;
  double systole_depth_m = 0;
};

// A finger held for some seconds.
Felt held(Trainer& trainer, const std::vector<Finger>& fingers, double seconds = 6) {
  Felt felt;
  Felt running;
  double strongest = 0;
  std::uint64_t beat = trainer.signals().beats;
  for (int n = 0; n < seconds / kTick; ++n) {
    const double force = trainer.tick(kTick, fingers)[0];
    const Signals& now = trainer.signals();
    if (now.beats != beat) {
      beat = now.beats;
      strongest = 0;
      running.diastole_n = force;
      running.diastole_depth_m = now.depth_m[0];
      felt = running;
    }
    if (now.elastance_mmhg_per_ml > strongest) {
      strongest = now.elastance_mmhg_per_ml;
      running.systole_n = force;
      running.systole_depth_m = now.depth_m[0];
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
  EXPECT_NEAR(trainer.signals().beat.output_l_per_min, 2.233, 0.01);
  EXPECT_NEAR(trainer.signals().natural_output_l_per_min, 2.233, 0.01);
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
  // Longer pressed it is K_v + K_e + pi p R = 145 N/m stiff; the wall that has just come back from
  // systole has still to give way.
  EXPECT_GT(felt.diastole_n, 0.008 * 140);
  EXPECT_LT(felt.diastole_n, 0.008 * 200);
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
    const double volume_ml =
        49.8 + 100 * (cylinder_of(49.8).side_area_cm2() * now.wall_m - 14.1 * dent_m);
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
      const double contractile = PalpationParameters{}.contractile.stiffness_n_per_m(
          1, shortening_area_cm2(now.beat.contracting_ml, 49.8), now.elastance_mmhg_per_ml);
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
  // Mean force on all fingers over a beat, after eleven, and the output.
  const auto pressed = [](const std::vector<Finger>& fingers) {
    Trainer trainer({}, fingers.size());
    double sum_n = 0;
    for (int n = 0; n < 6545; ++n) {
      for (const double force_n : trainer.tick(kTick, fingers)) sum_n += n < 6000 ? 0 : force_n;
    }
    return std::pair{sum_n / 545, trainer.signals().beat.output_l_per_min};
  };
  const auto forces = [&](double apart_mm) {
    Finger second = kPress;
    second.place_mm.x() = apart_mm;
    return pressed({kPress, second});
  };
  const auto [one_n, one_out] = pressed({kPress});
  const auto [close_n, close_out] = forces(0);
  const auto [far_n, far_out] = forces(500);
  // Two fingers at one place are one finger on one patch; far apart they are two.
  EXPECT_NEAR(close_out, one_out, 0.01);
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
  Circulation natural({});
  natural.settle();
  const double area_cm2 = shortening_area_cm2(natural.last_beat().contracting_ml, 49.8);
  const double diastole_mmhg = natural.filling_mmhg();
  double systole_mmhg = 0;
  for (double most = 0; natural.phase() < 0.7; natural.tick(kTick, -1)) {
    if (natural.elastance_mmhg_per_ml() <= most) continue;
    most = natural.elastance_mmhg_per_ml();
    systole_mmhg = natural.filling_mmhg();
  }
  const Contractile contractile;
  EXPECT_NEAR((75 + contractile.stiffness_n_per_m(1, area_cm2, 4.5) +
               pressure_n_per_m(systole_mmhg, 49.8)) /
                  (75 + contractile.stiffness_n_per_m(1, area_cm2, 0.19) +
                   pressure_n_per_m(diastole_mmhg, 49.8)),
              1.71, 0.02);  // the canine ratio
  const Felt healthy = held({}, kPress);
  PalpationParameters one;
  one.segments[kMiddleAnterior - 1].alpha = 0.3;
  const Felt weak = held(one, kPress);
  EXPECT_LT(weak.systole_n, 0.95 * healthy.systole_n);
}

TEST(Trainer, EveryRowOfTableOneIsFelt) {
  // Table 1's rows at twice, on a finger 8 mm deep: mean force over a beat, and the output.
  const auto pressed = [](auto change) {
    PalpationParameters parameters;
    for (MuscleConstants* place :
         {&parameters.muscle.base, &parameters.muscle.middle, &parameters.muscle.apex}) {
      change(*place);
    }
    Trainer trainer(parameters, 1);
    double sum_n = 0;
    for (int n = 0; n < 6545; ++n) {
      const double force_n = trainer.tick(kTick, std::vector<Finger>{kPress})[0];
      if (n >= 6000) sum_n += force_n / 545;
    }
    return std::pair{sum_n, trainer.signals().natural_output_l_per_min};
  };
  const auto [force, output] = pressed([](MuscleConstants&) {});
  const auto k_h1 = pressed([](MuscleConstants& m) { m.k_h1_n_per_m *= 2; });
  const auto k_h2 = pressed([](MuscleConstants& m) { m.k_h2_n_per_m *= 2; });
  const auto c_h = pressed([](MuscleConstants& m) { m.c_h_n_s_per_m *= 2; });
  const auto k_v = pressed([](MuscleConstants& m) { m.k_v_n_per_m *= 2; });
  const auto c_v = pressed([](MuscleConstants& m) { m.c_v_n_s_per_m *= 2; });
  EXPECT_LT(k_h2.second, 0.9 * output);     // a stiffer wall fills less
  EXPECT_LT(c_h.second, 0.999 * output);    // one that lets go more slowly, too
  EXPECT_GT(k_h1.second, 1.0001 * output);  // and more quickly, more
  for (const auto& changed : {k_h1, k_h2, c_h, k_v, c_v}) {
    EXPECT_GT(std::abs(changed.first / force - 1), 2e-4);
  }
  EXPECT_GT(k_v.first, 1.05 * force);
}

TEST(Trainer, TheAtriumsPressureIsFelt) {
  // Paper B: with a high pressure in the ventricle its muscle's own elasticity is hard to feel.
  const Felt low = held(palpation_preset("low_pressure"), kPress);
  const Felt healthy = held({}, kPress);
  const auto at_pressure = [](double left_atrial_mmhg) {  // the finger begins at its own wall
    PalpationParameters out;
    out.circulation.left_atrial_mmhg = left_atrial_mmhg;
    out.circulation.reference_volume_ml = natural_beat(out.whole_circulation()).edv_ml;
    return out;
  };
  const Felt congested = held(at_pressure(20), kPress);
  EXPECT_GT(force_jnds(healthy.diastole_n, low.diastole_n), 2);
  EXPECT_GT(healthy.diastole_n, low.diastole_n);
  EXPECT_GT(congested.diastole_n, healthy.diastole_n);
  // What disease takes from the wall is a smaller share of it.
  const auto share = [&](double left_atrial_mmhg) {
    PalpationParameters ill = at_pressure(left_atrial_mmhg);
    const Felt whole = held(ill, kPress);
    ill.segments[kMiddleAnterior - 1] = infarct_tissue();
    return held(ill, kPress).diastole_n / whole.diastole_n;
  };
  EXPECT_GT(share(20), share(3) + 0.05);
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
    const double k = 75 + contractile.stiffness_n_per_m(1, 7.3, 0.19 + 4.31 * e);
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
