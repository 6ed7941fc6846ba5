/// Slices and phases that foretell each other, of shapes for which it is known how well they do.
#include "pipeline/assess/self_test.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::assess {
namespace {

constexpr double kPi = std::numbers::pi;

/// A body of revolution about the stack's axis whose radius hangs on height and phase, as its share
/// of every pixel: linear in the distance from its edge over a pixel.
template <class Radius>
Segmentation body(
    int slices, double gap_mm, int phases, const Radius& radius_mm,
    Vec2 (*shift)(int slice) = [](int) { return Vec2(0, 0); }) {
  constexpr int kSize = 80;
  constexpr double kPixelMm = 1.25;
  Segmentation out;
  Grid& grid = out.coverage.grid;
  grid.size = {kSize, kSize, slices};
  // Turned in the patient: nothing may hang on the axes.
  grid.mm_from_index = Eigen::Translation3d(20, -40, 10) *
                       Eigen::AngleAxisd(0.5, Vec3(1, 0.3, -0.2).normalized()) *
                       Eigen::Scaling(kPixelMm, kPixelMm, gap_mm);
  for (int p = 0; p < phases; ++p) {
    std::vector<float> share;
    for (int k = 0; k < slices; ++k) {
      const double radius = radius_mm(gap_mm * (k - 0.5 * (slices - 1)), p);
      const Vec2 middle = shift(k);
      for (int n = 0; n < kSize * kSize; ++n) {
        const Vec2 at(kPixelMm * (n % kSize - 0.5 * (kSize - 1)),
                      kPixelMm * (n / kSize - 0.5 * (kSize - 1)));
        const double inside = radius - (at - middle).norm();
        share.push_back(static_cast<float>(std::clamp(0.5 + inside / kPixelMm, 0.0, 1.0)));
      }
    }
    out.coverage.phases[Structure::Heart].push_back(std::move(share));
  }
  out.labels.grid = grid;
  out.labels.phases.resize(static_cast<std::size_t>(phases));
  return out;
}

const HiddenError& heart_of(const std::vector<HiddenError>& rows) {
  static const HiddenError none;
  EXPECT_EQ(rows.size(), 1U);
  return rows.empty() ? none : rows.front();
}

SelfTest tested(const Segmentation& found) {
  StageContext context;
  return self_test(found, found.labels.grid, 0.8, {}, context);
}

TEST(SelfTest, OfACylinderFindsNothingBetweenItsSlices) {
  const SelfTest found = tested(body(10, 8, 1, [](double, int) { return 25.0; }));
  EXPECT_DOUBLE_EQ(found.slices_apart_mm, 16);
  const HiddenError& between = heart_of(found.between_slices);
  EXPECT_EQ(between.contours, 8);
  // Contours are found to a fraction of a pixel of 1.25 mm.
  EXPECT_LT(between.mm.p95, 0.15);
  EXPECT_LT(std::abs(between.mm.bias), 0.08);
  EXPECT_EQ(found.phases_apart_s, 0);
  EXPECT_TRUE(found.between_phases.empty());
}

TEST(SelfTest, OfABallBetweenTwoSlicesLosesWhatTheChordDoes) {
  // Slice 1 has one neighbour on one side, so that it lies on a straight line between slices 0 and
  // 2: across a gap of 16 mm that loses 16^2 R / (8 r^2) along the normal, r the radius there.
  // Slices further in lie on a cubic through four.
  const double radius = 45;
  const SelfTest found = tested(body(
      9, 8, 1, [&](double z, int) { return std::sqrt(std::max(0.0, radius * radius - z * z)); }));
  ASSERT_FALSE(found.worst.empty());
  EXPECT_EQ(found.worst.front().slice, 1);
  const double chord_mm = 16 * 16 * radius / (8 * (radius * radius - 24 * 24));
  EXPECT_NEAR(found.worst.front().mm.bias, -chord_mm, 0.15);
  EXPECT_LT(found.worst.back().mm.mean, 0.5 * chord_mm);
}

TEST(SelfTest, NamesTheSliceThatLiesAstray) {
  // One slice lies 4 mm aside: along the normals 4 |cos| of the angle, 2.5 mm in the mean.
  const SelfTest found = tested(body(
      12, 8, 1, [](double, int) { return 25.0; },
      [](int slice) { return Vec2(slice == 5 ? 4 : 0, 0); }));
  ASSERT_FALSE(found.worst.empty());
  EXPECT_EQ(found.worst.front().slice, 5);
  EXPECT_EQ(found.worst.front().structure, Structure::Heart);
  EXPECT_NEAR(found.worst.front().mm.mean, 4 * 2 / kPi, 0.3);
  EXPECT_NEAR(found.worst.front().mm.bias, 0, 0.2);
}

TEST(SelfTest, SaysOnWhichSideOfItsContourASliceWasForetold) {
  // One slice is 3 mm narrower than all others: foretold as much too far out.
  const SelfTest found =
      tested(body(12, 8, 1, [](double z, int) { return std::abs(z - 4) < 1 ? 22.0 : 25.0; }));
  ASSERT_FALSE(found.worst.empty());
  EXPECT_EQ(found.worst.front().slice, 6);
  EXPECT_NEAR(found.worst.front().mm.bias, 3, 0.3);
}

TEST(SelfTest, OfAnEndIsToldApart) {
  // A cone's tip lies between two slices, and no slice beyond it tells where.
  const SelfTest found =
      tested(body(10, 8, 1, [](double z, int) { return std::max(0.0, 0.6 * (z + 30)); }));
  EXPECT_FALSE(found.at_ends.empty());
  EXPECT_LT(heart_of(found.between_slices).mm.mean, 0.5);
}

TEST(SelfTest, AsksNoSliceWhichIsTheLastBeforeAValve) {
  // A cylinder that ends in the stack on both sides.
  const auto cylinder = [](double z, int) { return std::abs(z) < 26 ? 25.0 : 0.0; };
  Segmentation found = body(10, 8, 1, cylinder);
  const int without = heart_of(tested(found).at_ends).contours;
  EXPECT_EQ(without, 2);
  for (const int step : {1, -1}) {
    found.valve_planes[Structure::Heart] = {step, {step > 0 ? 7.5 : 1.5}};
    EXPECT_EQ(heart_of(tested(found).at_ends).contours, 1) << step;
  }
}

TEST(SelfTest, OfHiddenPhasesIsTheCubicsOwnError) {
  // Radii that go round the beat in one wave and in three: in the middle between four phases a
  // cubic keeps (9 cos d - cos 3 d) / 8 of a wave whose phase moves by d from frame to frame.
  constexpr int kPhases = 12;
  for (const int waves : {1, 3}) {
    const auto radius = [&](double, int p) {
      return 25 + 4 * std::cos(2 * kPi * waves * p / kPhases);
    };
    const SelfTest found = tested(body(8, 8, kPhases, radius));
    EXPECT_DOUBLE_EQ(found.phases_apart_s, 2 * 0.8 / kPhases);
    const double d = 2 * kPi * waves / kPhases;
    const double lost = 1 - (9 * std::cos(d) - std::cos(3 * d)) / 8;
    double mean = 0;
    for (int p = 0; p < kPhases; ++p) {
      mean += std::abs(4 * lost * std::cos(2 * kPi * waves * p / kPhases)) / kPhases;
    }
    // Contours are found to a twentieth of a pixel.
    EXPECT_NEAR(heart_of(found.between_phases).mm.mean, mean, 0.06 + 0.03 * mean) << waves;
  }
}

TEST(SelfTest, HidesWhatEveryOtherSliceSaysAndNothingElse) {
  Segmentation found = body(7, 8, 2, [](double, int p) { return p == 0 ? 25.0 : 20.0; });
  found.valve_planes[Structure::Heart] = {1, {5.5, 4.5}};
  const Segmentation half = every_other_slice(found, found.labels.grid, 1, {1});
  EXPECT_EQ(half.coverage.grid.size[2], 3);
  EXPECT_TRUE(half.coverage.grid.mm(3, 4, 2).isApprox(found.coverage.grid.mm(3, 4, 5), 1e-12));
  ASSERT_EQ(half.coverage.phases.at(Structure::Heart).size(), 1U);
  // The plane at slice 4.5 of the stack lies at (4.5 - 1) / 2 of the new one.
  EXPECT_DOUBLE_EQ(half.valve_planes.at(Structure::Heart).k.at(0), 1.75);
}

TEST(SelfTest, NeedsSlicesThatCanForetellEachOther) {
  const Segmentation found = body(3, 8, 1, [](double, int) { return 25.0; });
  try {
    (void)tested(found);
    ADD_FAILURE() << "three slices were taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    EXPECT_NE(std::string(error.what()).find("in 3 slices"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace beatlas::assess
