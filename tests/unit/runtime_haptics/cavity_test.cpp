// Hard cases 16 and 17: a catheter's tip in a cavity that beats, and through its valve.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/haptics/cavity_field.h"
#include "runtime/haptics/proxy.h"
#include "runtime/haptics/tube_field.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics::cavity_tests {
namespace {

using testing::FormField;
using testing::made_sample;
using Field = std::shared_ptr<const ContactField>;

constexpr double kPi = std::numbers::pi;
constexpr double kTick = 0.001;
constexpr double kBeat = 0.75;
constexpr double kTipMm = 1;
constexpr double kDepthMm = 11;  // how far into the blood an atlas knows directions

/// A ventricle: a tube with a round apex, cut flat at the base, 122 ml at its largest and 41 at its
/// least. Wall and base move by 8 and 12 mm within half a beat.
struct Ventricle {
  bool cut;  ///< else both ends are round, which has no edge

  static double radius(double t) { return 22 + 4 * std::sin(2 * kPi * t / kBeat); }
  static double base(double t) { return 34 + 6 * std::sin(2 * kPi * t / kBeat); }

  [[nodiscard]] field::FieldSample sample(const Vec3& x, double t) const {
    const double slow = 2 * kPi / kBeat * std::cos(2 * kPi * t / kBeat);
    const double top = cut ? 100 : base(t) - radius(t);
    const Vec3 off = x - std::clamp(x.z(), 0.0, top) * Vec3::UnitZ();
    const Vec3 out = off.norm() > 0 ? Vec3(off.normalized()) : Vec3::UnitX();
    // The rate of the round end's middle is that of the base less the radius.
    const double carried = x.z() > top ? 2 * slow * out.z() : 0;
    if (cut && x.z() - base(t) > off.norm() - radius(t)) {
      return made_sample(x.z() - base(t), Vec3::UnitZ(), -6 * slow);
    }
    return made_sample(off.norm() - radius(t), out, -4 * slow - carried);
  }
};

Field form(const Ventricle& ventricle) {
  return std::make_shared<const FormField>(
      1.5, kBeat, [ventricle](const Vec3& x, double t) { return ventricle.sample(x, t); });
}

Field exact(const Ventricle& ventricle) {
  return std::make_shared<const CavityField>(std::vector<Field>{form(ventricle)}, kDepthMm);
}

Field packed(const Ventricle& ventricle) {
  const Field atlas =
      testing::packed({.origin_mm = Vec3(-47.25, -47.25, -47.25),
                       .blocks = {8, 8, 9},
                       .rr_interval_s = kBeat,
                       .inner_mm = 12,
                       .outer_mm = 12},
                      [=](const Vec3& x, double t) { return ventricle.sample(x, t).distance_mm; });
  return std::make_shared<const CavityField>(std::vector<Field>{atlas}, kDepthMm);
}

/// Where a tool is at each tick of a straight way, the end included.
std::vector<Vec3> straight(const Vec3& from, const Vec3& to, double speed_mm_s) {
  const int ticks =
      std::max(1, static_cast<int>(std::ceil((to - from).norm() / speed_mm_s / kTick)));
  std::vector<Vec3> out;
  for (int n = 1; n <= ticks; ++n) out.emplace_back(from + n * (to - from) / ticks);
  return out;
}

struct Worst {
  double contact_mm = 0;   ///< of the tip's surface from the wall while it touches
  double free_n = 0;       ///< force while the tip is free by more than `contact_mm` may be
  double depth_error = 0;  ///< of the force, against K times the way back into the blood [N]
  int thrown_out = 0;      ///< ticks at which the proxy's centre was out of the blood
  int touched = 0;         ///< ticks
  bool is_finite = true;
};

/// Strokes at 0.1 to 1 m/s from somewhere in the blood to up to 14 mm behind the wall, along it and
/// back, through beat after beat.
Worst walk(const Field& field, const Ventricle& ventricle, int strokes, double limit_mm) {
  std::mt19937 random(16);
  std::uniform_real_distribution<double> u(0, 1);
  std::normal_distribution<double> normal;
  ProxyModel model(field, {.radius_mm = kTipMm});
  Worst worst;
  Vec3 x(0, 0, 10);
  double t = 0;
  for (int stroke = 0; stroke < strokes; ++stroke) {
    const Vec3 way = Vec3(normal(random), normal(random), normal(random)).normalized();
    const Vec3 to = Vec3(0, 0, 10 + 4 * u(random)) + (8 + 20 * u(random)) * way;
    const double speed_mm_s = 100 + 900 * u(random);
    for (const Vec3& place : straight(x, to, speed_mm_s)) {
      x = place;
      t += kTick;
      const Contact contact = model.evaluate(x, t, kTick);
      worst.is_finite = worst.is_finite && contact.force_n.allFinite();
      const double wall_mm = -ventricle.sample(contact.proxy_mm, t).distance_mm;
      worst.thrown_out += wall_mm <= 0 ? 1 : 0;
      const double free_mm = -ventricle.sample(x, t).distance_mm - kTipMm;
      if (free_mm > limit_mm) worst.free_n = std::max(worst.free_n, contact.force_n.norm());
      if (!contact.touching) continue;
      ++worst.touched;
      worst.contact_mm = std::max(worst.contact_mm, std::abs(wall_mm - kTipMm));
      worst.depth_error =
          std::max(worst.depth_error,
                   std::abs(contact.force_n.norm() - 150e-3 * (contact.proxy_mm - x).norm()));
    }
  }
  return worst;
}

TEST(HardCase16, ATipInABeatingCavityIsFreeInTheBloodAndHeldByTheWall) {
  for (const bool cut : {false, true}) {
    const Ventricle ventricle{cut};
    constexpr double kLimitMm = 0.001;  // to which the proxy seeks its place
    const Worst worst = walk(exact(ventricle), ventricle, 3000, kLimitMm);
    EXPECT_TRUE(worst.is_finite);
    EXPECT_EQ(worst.thrown_out, 0);
    EXPECT_EQ(worst.free_n, 0);
    EXPECT_LE(worst.contact_mm, kLimitMm);
    EXPECT_LE(worst.depth_error, 1e-9);
    EXPECT_GT(worst.touched, 10000);
    std::printf("  case 16, %s, closed form: contact error %.4f mm in %d ticks\n",
                cut ? "flat base" : "round ends", worst.contact_mm, worst.touched);
  }
}

TEST(HardCase16, SoItIsInAnAtlas) {
  const Ventricle ventricle{false};
  constexpr double kLimitMm = 0.02;  // what samples 1.5 mm and 50 ms apart leave of this motion
  const Worst worst = walk(packed(ventricle), ventricle, 1500, kLimitMm);
  EXPECT_TRUE(worst.is_finite);
  EXPECT_EQ(worst.thrown_out, 0);
  EXPECT_EQ(worst.free_n, 0);
  EXPECT_LE(worst.contact_mm, kLimitMm);
  EXPECT_GT(worst.touched, 5000);
  std::printf("  case 16, round ends, atlas: contact error %.4f mm in %d ticks\n", worst.contact_mm,
              worst.touched);
}

TEST(HardCase16, ACapsuleInACavityLiesWithBothEndsInTheBlood) {
  const Ventricle ventricle{false};
  ProxyModel model(exact(ventricle), {.radius_mm = kTipMm, .half_length_mm = 5});
  std::mt19937 random(17);
  std::uniform_real_distribution<double> u(-1, 1);
  double deepest_mm = 0;
  int touched = 0;
  for (int n = 0; n < 20000; ++n) {
    const double t = kTick * n;
    // The device's path goes 6 mm into the wall, and turns slowly.
    const Vec3 x(28 * std::cos(0.8 * t), 28 * std::sin(0.8 * t), 8 * std::sin(0.5 * t));
    const Eigen::Quaterniond turned(
        Eigen::AngleAxisd(0.7 * t, Vec3(1, std::sin(0.1 * t), 0.3).normalized()));
    const Contact contact = model.evaluate({.time_s = t, .position_mm = x, .orientation = turned},
                                           {.elapsed_s = n > 0 ? kTick : 0, .field_time_s = t});
    if (!contact.touching) continue;
    ++touched;
    for (const double end : {-5.0, 5.0}) {
      const Vec3 at = contact.proxy_mm + end * (turned * Vec3::UnitZ());
      deepest_mm = std::max(deepest_mm, ventricle.sample(at, t).distance_mm + kTipMm);
    }
  }
  EXPECT_GT(touched, 10000);
  EXPECT_LE(deepest_mm, 0.2);
}

constexpr int kPhases = 15;

/// The way through the valve of the ventricle with a flat base, as 15 phases tell it.
std::shared_ptr<const TubeField> valve() {
  std::vector<Opening> phases;
  for (int p = 0; p < kPhases; ++p) {
    const double t = kBeat * p / kPhases;
    phases.push_back({.centre_mm = Vec3(2, 0, Ventricle::base(t)),
                      .normal = Vec3(0.1, 0, 1).normalized(),
                      .radius_mm = 9 + std::sin(2 * kPi * t / kBeat)});
  }
  return std::make_shared<const TubeField>(std::move(phases), kBeat);
}

TEST(Tube, IsItsClosedFormAndGradientAndRateAreItsDifferences) {
  const std::shared_ptr<const TubeField> tube = valve();
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 x(30 * u(random), 30 * u(random), 30 + 50 * u(random));
    const double t = u(random);
    const Opening opening = tube->at(t);
    // What Catmull and Rom's spline leaves of a sine of 6 mm and 15 phases a beat.
    EXPECT_NEAR(opening.centre_mm.z(), Ventricle::base(t), 0.03);
    const double along = std::clamp((x - opening.centre_mm).dot(opening.normal), -10.0, 30.0);
    const double exact_mm =
        (x - opening.centre_mm - along * opening.normal).norm() - opening.radius_mm;
    const field::FieldSample sample = tube->sample(x, t);
    EXPECT_NEAR(sample.distance_mm, exact_mm, 1e-9);
    constexpr double kStep = 1e-5;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 step = kStep * Vec3::Unit(axis);
      const double slope =
          (tube->sample(x + step, t).distance_mm - tube->sample(x - step, t).distance_mm) /
          (2 * kStep);
      EXPECT_NEAR(sample.gradient[axis], slope, 1e-4);
    }
    const double rate =
        (tube->sample(x, t + kStep).distance_mm - tube->sample(x, t - kStep).distance_mm) /
        (2 * kStep);
    EXPECT_NEAR(sample.rate_mm_s, rate, 0.05);
  }
  EXPECT_THROW(TubeField({}, 1), Error);
  EXPECT_THROW(TubeField({{.radius_mm = 0}}, 1), Error);
  EXPECT_THROW(TubeField({{.normal = Vec3(0, 0, 2), .radius_mm = 3}}, 1), Error);
  EXPECT_THROW(TubeField({{.radius_mm = 3}}, 0), Error);
}

// Hard case 17: from the atrium through the valve into the ventricle and back, beat after beat,
// with strokes that end behind the walls of all three.
TEST(HardCase17, ATipGoesThroughABeatingValveAndIsNeverOutOfTheBlood) {
  const Ventricle ventricle{true};
  const std::shared_ptr<const TubeField> tube = valve();
  const Field atrium = std::make_shared<const FormField>(1.5, kBeat, [](const Vec3& x, double t) {
    const Vec3 off = x - Vec3(4, 0, Ventricle::base(t) + 30);
    const double slow = 6 * 2 * kPi / kBeat * std::cos(2 * kPi * t / kBeat);
    return made_sample(off.norm() - 20, off.normalized(), -slow * off.normalized().z());
  });
  const std::vector<Field> parts{form(ventricle), tube, atrium};
  ProxyModel model(std::make_shared<const CavityField>(parts, kDepthMm - 3), {.radius_mm = kTipMm});
  const auto blood_mm = [&](const Vec3& x, double t) {
    double deepest = -1e9;
    for (const Field& part : parts) deepest = std::max(deepest, -part->sample(x, t).distance_mm);
    return deepest;
  };
  // A proxy that slips over the rim where two of the cavities meet may end a tick on its way, with
  // a step s of 0.75 mm: into a wall of 7 mm radius by s^2 / 2 r, or half a step short of it.
  constexpr double kIntoMm = 0.04;
  constexpr double kShortMm = 0.375;
  std::mt19937 random(18);
  std::uniform_real_distribution<double> u(0, 1);
  std::normal_distribution<double> normal;
  Vec3 x(3, 0, Ventricle::base(0) + 15);
  double t = 0;
  double into_mm = 0;
  double short_mm = 0;
  double free_n = 0;
  int thrown_out = 0;
  int touched = 0;
  int passed = 0;
  int side = 1;
  for (int stroke = 0; stroke < 2000; ++stroke) {
    // Every other one leads along the axis to the other side.
    const Vec3 way = Vec3(normal(random), normal(random), normal(random)).normalized();
    const Vec3 to = stroke % 2 == 0 ? Vec3(2, 0, stroke % 4 == 0 ? 12 : Ventricle::base(t) + 25)
                                    : Vec3(x + (5 + 20 * u(random)) * way);
    const double speed_mm_s = 50 + 450 * u(random);
    for (const Vec3& place : straight(x, to, speed_mm_s)) {
      x = place;
      t += kTick;
      const Contact contact = model.evaluate(x, t, kTick);
      ASSERT_TRUE(contact.force_n.allFinite());
      const double wall_mm = blood_mm(contact.proxy_mm, t);
      thrown_out += wall_mm <= 0 ? 1 : 0;
      if (!contact.touching) free_n = std::max(free_n, contact.force_n.norm());
      const int now = contact.proxy_mm.z() > Ventricle::base(t) + 5   ? 1
                      : contact.proxy_mm.z() < Ventricle::base(t) - 5 ? -1
                                                                      : side;
      passed += now != side ? 1 : 0;
      side = now;
      if (!contact.touching) continue;
      ++touched;
      into_mm = std::max(into_mm, kTipMm - wall_mm);
      short_mm = std::max(short_mm, wall_mm - kTipMm);
    }
  }
  std::printf("  case 17: %.4f mm into the wall, %.4f short of it in %d ticks, %d passes\n",
              into_mm, short_mm, touched, passed);
  EXPECT_EQ(thrown_out, 0);
  EXPECT_EQ(free_n, 0);
  EXPECT_LE(into_mm, kIntoMm);
  EXPECT_LE(short_mm, kShortMm);
  EXPECT_GT(touched, 5000);
  EXPECT_GT(passed, 300);
}

TEST(Cavity, RefusesWhatIsNoCavity) {
  EXPECT_THROW(CavityField({}, 1), Error);
  EXPECT_THROW(CavityField({nullptr}, 1), Error);
  EXPECT_THROW(CavityField({exact({false})}, 0), Error);
  EXPECT_THROW(ProxyModel(exact({false}), {.radius_mm = kDepthMm + 1}), Error);
}

}  // namespace
}  // namespace beatlas::haptics::cavity_tests
