#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/haptics/servo.h"
#include "runtime/haptics/shell.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics::shell_taxels_tests {
namespace {

using testing::FormField;
using testing::made_sample;
using Field = std::shared_ptr<const ContactField>;

constexpr int kSide = TaxelMap::kSide;
constexpr double kPi = std::numbers::pi;
constexpr double kBedKpaPerMm = 1.5;  // of ShellOptions: 1.5e6 N/m^3
constexpr double kRadius = 8;

Field floor_below() {
  return std::make_shared<const FormField>(
      1.5, 1, [](const Vec3& x, double) { return made_sample(x.z(), Vec3::UnitZ()); });
}

/// The sum of a map's pressures [N].
double force_of(const TaxelMap& map) {
  double sum = 0;
  for (const float p : map.pressure_kpa) sum += static_cast<double>(p);
  return sum * map.pitch_mm * map.pitch_mm * 1e-3;
}

/// Mean of a pressure over a taxel [kPa], by a sum over 40 x 40 places.
template <class Pressure>
double mean_kpa(int row, int column, double pitch_mm, const Pressure& pressure) {
  constexpr int kFine = 40;
  double sum = 0;
  for (int j = 0; j < kFine; ++j) {
    for (int i = 0; i < kFine; ++i) {
      sum += pressure(std::hypot((column - kSide / 2 + (i + 0.5) / kFine) * pitch_mm,
                                 (row - kSide / 2 + (j + 0.5) / kFine) * pitch_mm));
    }
  }
  return sum / (kFine * kFine);
}

/// Of Winkler's bed under a ball that has gone `depth_mm` into a flat body.
double bed_kpa(double r_mm, double depth_mm) {
  const double left = kRadius * kRadius - r_mm * r_mm;
  if (left <= 0) return 0;
  return kBedKpaPerMm * std::max(0.0, std::sqrt(left) - (kRadius - depth_mm));
}

/// The same as the model has it, whose areas are of the ball and not of the plane: 1 / cos of what
/// the ball is inclined by.
double shell_kpa(double r_mm, double depth_mm) {
  const double left = kRadius * kRadius - r_mm * r_mm;
  return left <= 0 ? 0 : bed_kpa(r_mm, depth_mm) * kRadius / std::sqrt(left);
}

/// @param border taxels along the map's border that are passed over
template <class Pressure>
void expect_pressure(const TaxelMap& map, double within_kpa, const Pressure& pressure,
                     int border = 0) {
  for (int row = border; row < kSide - border; ++row) {
    for (int column = border; column < kSide - border; ++column) {
      EXPECT_NEAR(map.pressure_kpa[static_cast<std::size_t>(row * kSide + column)],
                  mean_kpa(row, column, map.pitch_mm, pressure), within_kpa)
          << row << ' ' << column;
    }
  }
}

TEST(ShellTaxels, AFingertipOnAFlatBedIsTheClosedForm) {
  struct Case {
    std::size_t points;
    double within;  // of the peak
  };
  for (const auto& [points, within] : {Case{2000, 0.02}, Case{10000, 0.01}}) {
    ShellModel model(floor_below(), fingertip(kRadius, points), {});
    for (const double depth : {0.5, 1.0, 2.0, 4.0}) {
      SCOPED_TRACE(std::to_string(points) + " points, mm deep: " + std::to_string(depth));
      const Contact contact = model.evaluate({.position_mm = Vec3(3, -2, kRadius - depth)}, {});
      const TaxelMap map = model.taxels(Vec3::UnitX());
      const double peak = kBedKpaPerMm * depth;
      expect_pressure(map, within * peak, [&](double r) { return shell_kpa(r, depth); });
      // Where the ball is hardly inclined to the plane it is Winkler's bed itself.
      if (depth <= 1) {
        expect_pressure(map, 0.03 * peak, [&](double r) { return bed_kpa(r, depth); });
      }
      EXPECT_NEAR(map.peak_kpa, kBedKpaPerMm * contact.depth_mm, 1e-9);
      EXPECT_NEAR(map.peak_kpa, peak, 0.01 * peak);
      const double area = kPi * (2 * kRadius * depth - depth * depth);
      EXPECT_NEAR(map.area_mm2, area, 0.02 * area);
      EXPECT_NEAR(force_of(map), contact.force_n.norm(), 1e-5 * contact.force_n.norm());
      EXPECT_NEAR(map.pitch_mm, kRadius / 4, 1e-12);
      EXPECT_LT((map.centre_mm - Vec3(3, -2, 0)).norm(), 1e-9);
    }
  }
}

TEST(ShellTaxels, TheSumIsTheForceHoweverTheFingerLies) {
  const Vec3 axes(20, 15, 25);
  const Field field =
      testing::packed({.origin_mm = Vec3::Constant(-35), .blocks = {6, 6, 6}, .phases = 1},
                      [&](const Vec3& x, double) { return testing::ellipsoid_distance(axes, x); });
  ShellModel model(field, fingertip(7, 2000), {});
  int touched = 0;
  for (int n = 0; n < 40; ++n) {
    const Vec3 out = Vec3(std::sin(0.7 * n), std::cos(1.1 * n), std::sin(0.3 * n)).normalized();
    const Contact contact =
        model.evaluate({.position_mm = (18 + 0.3 * n) * out,
                        .orientation = Eigen::Quaterniond::FromTwoVectors(Vec3(0.2, 0, 1), out)},
                       {});
    const TaxelMap map = model.taxels(Vec3::UnitX());
    EXPECT_NEAR(force_of(map), contact.force_n.norm(), 1e-5 * contact.force_n.norm()) << n;
    for (const float p : map.pressure_kpa) EXPECT_GE(p, 0) << n;
    if (!contact.touching) continue;
    ++touched;
    EXPECT_NEAR(map.right.norm(), 1, 1e-12);
    EXPECT_LT((map.right.cross(map.up) - contact.normal).norm(), 1e-9) << n;
    EXPECT_GT(map.right.x(), 0) << n;
  }
  EXPECT_GT(touched, 20);
}

// A plate of 12 x 12 mm, tilted by s about y: deeper by x sin s where x cos s is.
TEST(ShellTaxels, ATiltedPlatePressesOnItsLowerSide) {
  Shell plate;
  constexpr int kFine = 96;
  for (int i = 0; i < kFine; ++i) {
    for (int j = 0; j < kFine; ++j) {
      plate.points_mm.emplace_back(-6 + 12 * (i + 0.5) / kFine, -6 + 12 * (j + 0.5) / kFine, 0);
      plate.areas_mm2.push_back(144.0 / (kFine * kFine));
    }
  }
  ShellModel model(floor_below(), plate, {});
  constexpr double kTilt = 0.1;
  (void)model.evaluate({.position_mm = Vec3(0, 0, -2),
                        .orientation = Eigen::Quaterniond(Eigen::AngleAxisd(kTilt, Vec3::UnitY()))},
                       {});
  for (const Vec3& right : {Vec3(1, 0, 1), Vec3(0, -1, 0)}) {
    const TaxelMap map = model.taxels(right, 1);
    EXPECT_LT((map.right - Vec3(right.x(), right.y(), 0)).norm(), 1e-12);
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        // The taxels at the border have half a point more or less.
        const Vec3 at = (column - 3.5) * map.right + (row - 3.5) * map.up;
        const double kpa = kBedKpaPerMm * (2 + at.x() * std::tan(kTilt)) / std::cos(kTilt);
        EXPECT_NEAR(map.pressure_kpa[static_cast<std::size_t>(row * kSide + column)], kpa,
                    0.03 * kpa);
      }
    }
    // Without normals areas count whole.
    EXPECT_NEAR(map.area_mm2, 144, 1e-9);
  }
}

TEST(ShellTaxels, WhatLiesBesideASmallMapIsLeftOut) {
  ShellModel model(floor_below(), fingertip(kRadius, 10000), {});
  const Contact contact = model.evaluate({.position_mm = Vec3(0, 0, kRadius - 2)}, {});
  const TaxelMap whole = model.taxels(Vec3::UnitX());
  const TaxelMap small = model.taxels(Vec3::UnitX(), 0.5);
  EXPECT_GT(force_of(small), 0);
  EXPECT_LT(force_of(small), 0.5 * contact.force_n.norm());
  EXPECT_EQ(small.area_mm2, whole.area_mm2);
  EXPECT_EQ(small.peak_kpa, whole.peak_kpa);
  // Half-millimetre taxels are of six points each.
  expect_pressure(
      small, 0.05 * small.peak_kpa, [](double r) { return shell_kpa(r, 2); }, 1);
}

void expect_silent(const TaxelMap& map) {
  EXPECT_EQ(map.area_mm2, 0);
  EXPECT_EQ(map.peak_kpa, 0);
  EXPECT_EQ(map.right, Vec3::Zero());
  for (const float p : map.pressure_kpa) EXPECT_EQ(p, 0);
}

TEST(ShellTaxels, NothingIsFeltWhereNothingIsTouched) {
  ShellModel model(floor_below(), fingertip(kRadius, 1000), {});
  const ServoState in{.position_mm = Vec3(0, 0, kRadius - 2)};
  expect_silent(model.taxels(Vec3::UnitX()));
  for (const double z : {1000.0, kRadius + 0.5}) {
    (void)model.evaluate(in, {});
    EXPECT_GT(model.taxels(Vec3::UnitX()).peak_kpa, 0);
    (void)model.evaluate({.position_mm = Vec3(0, 0, z)}, {});
    expect_silent(model.taxels(Vec3::UnitX()));
  }
  (void)model.evaluate(in, {});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double pitch : {-1.0, 0.01, 21.0, nan}) {
    expect_silent(model.taxels(Vec3::UnitX(), pitch));
  }
  model.reset();
  expect_silent(model.taxels(Vec3::UnitX()));
}

TEST(ShellTaxels, AnotherThreadHasThemOfTheForceThatIsFelt) {
  const auto shell = [] {
    return std::make_unique<ShellModel>(floor_below(), fingertip(kRadius, 2000), ShellOptions{});
  };
  const auto beside = shell();
  for (const double peak_n : {0.5, 40.0}) {
    Servo servo({.model = shell(), .period_s = 1},
                {.safety = {.peak_n = peak_n, .slew_n_per_s = 5000, .start_ramp_s = 0},
                 .heart = {},
                 .recorded_ticks = 0});
    ServoState state{.position_mm = Vec3(0, 0, kRadius - 3),
                     .orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vec3::UnitX()))};
    Tick tick;
    for (int n = 0; n < 1000; ++n) {
      state.time_s = 0.001 * n;
      tick = servo.tick(state);
    }
    const TaxelMap map = taxels_of(*beside, servo.published(), 0, Vec3::UnitY());
    const double felt_n = tick.force_n.dot(tick.contact.normal);
    EXPECT_NEAR(force_of(map), felt_n, 1e-5 * felt_n);
    EXPECT_NEAR(map.peak_kpa,
                kBedKpaPerMm * tick.contact.depth_mm * felt_n / tick.contact.force_n.norm(), 1e-9);
    EXPECT_LT((map.right - Vec3::UnitY()).norm(), 1e-6);
    servo.stop();
    state.time_s += 0.001;
    (void)servo.tick(state);
    expect_silent(taxels_of(*beside, servo.published(), 0, Vec3::UnitY()));
  }
  EXPECT_NEAR(taxels_of(*beside, {}, 0, Vec3::UnitX()).pitch_mm, kRadius / 4, 1e-12);
}

TEST(ShellTaxels, NormalsThatAreNoneAreRefused) {
  EXPECT_THROW(ShellModel(floor_below(), {{Vec3::Zero()}, {1}, {Vec3::Zero()}}, {}), Error);
  EXPECT_THROW(ShellModel(floor_below(), {{Vec3::Zero()}, {1}, {Vec3::UnitX(), Vec3::UnitX()}}, {}),
               Error);
  EXPECT_THROW(ShellModel(floor_below(), {{Vec3::Zero()}, {1}, {Vec3(0, 0, std::nan(""))}}, {}),
               Error);
}

}  // namespace
}  // namespace beatlas::haptics::shell_taxels_tests
