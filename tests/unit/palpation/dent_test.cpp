#include "runtime/palpation/dent.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::palpation {
namespace {

TEST(Dent, IsAsLargeAsTheContactAreaAndSmooth) {
  const double radius_mm = dent_radius_mm(14.1);
  double area_mm2 = 0;
  constexpr int kRings = 20000;
  for (int n = 0; n < kRings; ++n) {
    const double r = radius_mm * (n + 0.5) / kRings;
    area_mm2 += 2 * std::numbers::pi * r * radius_mm / kRings * dent_weight(r / radius_mm);
  }
  EXPECT_NEAR(area_mm2, 1410, 1e-3);
  EXPECT_EQ(dent_weight(0), 1);
  EXPECT_EQ(dent_weight(1), 0);
  EXPECT_EQ(dent_weight(7), 0);
  const double h = 1e-4;  // flat at its middle and at its edge
  EXPECT_NEAR(dent_weight(h), 1, 20 * h * h);
  EXPECT_LT(dent_weight(1 - h), 10 * h * h * h * h);
}

TEST(Dent, FitsItsAreaOnACurvedSurface) {
  // Evenly on a sphere of 30 mm.
  std::vector<Vec3> points;
  std::vector<double> areas;
  constexpr int kPoints = 20000;
  for (int n = 0; n < kPoints; ++n) {
    const double z = 1 - 2 * (n + 0.5) / kPoints;
    const double turn = std::numbers::pi * (3 - std::sqrt(5.0)) * n;
    const double r = std::sqrt(1 - z * z);
    points.emplace_back(30 * Vec3(r * std::cos(turn), r * std::sin(turn), z));
    areas.push_back(4 * std::numbers::pi * 900 / kPoints);
  }
  const Vec3 top(0, 0, 30);
  const double radius_mm = dent_radius_on_mm(points, areas, top, 14.1);
  double sum = 0;
  for (std::size_t n = 0; n < points.size(); ++n) {
    sum += areas[n] * dent_weight((points[n] - top).norm() / radius_mm);
  }
  EXPECT_NEAR(sum, 1410, 0.01);
  // Chords of a sphere cut the same area as in a plane, so the radius is the same.
  EXPECT_NEAR(radius_mm, dent_radius_mm(14.1), 0.01 * radius_mm);
  EXPECT_THROW((void)dent_radius_on_mm(points, areas, top, 500), Error);
  EXPECT_THROW((void)dent_radius_on_mm({}, {}, top, 14.1), Error);
}

TEST(Dent, EveryFingerThatTouchesLiesOnTheSurface) {
  DentField field(dent_radius_mm(14.1));
  const std::vector<DentSource> fingers{
      {Vec3(0, 0, 0), 8}, {Vec3(15, 0, 0), 6}, {Vec3(70, 5, 0), 4}};
  field.set(fingers);
  for (const DentSource& finger : fingers) {
    EXPECT_NEAR(field.depression_mm(finger.place_mm), finger.depth_mm, 1e-5);
  }
  EXPECT_EQ(field.depression_mm(Vec3(300, 0, 0)), 0);
}

TEST(Dent, AFingerInAnothersDentTouchesNothing) {
  DentField field(50);
  field.set(std::vector<DentSource>{{Vec3(0, 0, 0), 8}, {Vec3(10, 0, 0), 2}});
  EXPECT_EQ(field.amplitudes_mm()[1], 0);
  EXPECT_NEAR(field.amplitudes_mm()[0], 8, 1e-12);
  EXPECT_GT(field.depression_mm(Vec3(10, 0, 0)), 2);
  field.set(std::vector<DentSource>{{Vec3(0, 0, 0), -3}});
  EXPECT_EQ(field.depression_mm(Vec3(0, 0, 0)), 0);
}

TEST(Dent, TwoFingersAtOnePlaceAreOneAndFarOnesAreTwo) {
  DentField field(50);
  field.set(std::vector<DentSource>{{Vec3(0, 0, 0), 5}, {Vec3(1e-6, 0, 0), 5}});
  EXPECT_NEAR(field.whole_depth_mm(), 5, 1e-4);
  field.set(std::vector<DentSource>{{Vec3(0, 0, 0), 5}, {Vec3(200, 0, 0), 5}});
  EXPECT_NEAR(field.whole_depth_mm(), 10, 1e-12);
}

}  // namespace
}  // namespace beatlas::palpation
