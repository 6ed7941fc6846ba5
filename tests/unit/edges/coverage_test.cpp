/// Coverage of structures that lie within each other.
#include "pipeline/edges/coverage.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace beatlas::edges::coverage_tests {
namespace {

constexpr double kPixelMm = 2;
constexpr int kSide = 48;
constexpr double kCavityMm = 20;
constexpr double kOutsideMm = 25.5;
const tissue::TissueLevels kLevels{
    .blood = 1000, .rv_blood = 1000, .muscle = 300, .threshold = 650, .dark = 150};

/// A cavity in a wall of less than three pixels amid fat, in two slices and two phases.
struct Ring {
  ImageCycle<float> images;
  LabelCycle labels;
};

/// @param cavity_mm, outside_mm radii in the labels; no wall where these are the same
Ring ring(double cavity_mm, double outside_mm) {
  constexpr int kParts = 8;  // of a pixel, along either edge
  Grid grid;
  grid.size = {kSide, kSide, 2};
  grid.mm_from_index.linear() = Vec3(kPixelMm, kPixelMm, 10).asDiagonal();
  std::vector<float> image;
  std::vector<std::uint8_t> labels;
  const double middle = 0.5 * kPixelMm * (kSide - 1) + 0.3;
  for (int k = 0; k < 2; ++k) {
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        double sum = 0;
        for (int n = 0; n < kParts * kParts; ++n) {
          const double x = kPixelMm * (i + (n % kParts + 0.5) / kParts - 0.5) - middle;
          const double y = kPixelMm * (j + (n / kParts + 0.5) / kParts - 0.5) - middle;
          const double r = std::hypot(x, y);
          sum += r < kCavityMm ? 1000 : r < kOutsideMm ? 300 : 900;
        }
        image.push_back(static_cast<float>(sum / (kParts * kParts)));
        const double r = std::hypot(kPixelMm * i - middle, kPixelMm * j - middle);
        labels.push_back(r < cavity_mm    ? kLabelLvBlood
                         : r < outside_mm ? kLabelLvMyocardium
                                          : kLabelBackground);
      }
    }
  }
  return {{grid, {image, image}}, {grid, {labels, labels}}};
}

Covered covered(const Ring& of) {
  return cover(of.images, of.labels, Box{{0, 0, 0}, of.images.grid.size}, kLevels, 5);
}

/// [mm] Of a disc as large as the mean section.
double radius_mm(const CoverageCycle& coverage, std::initializer_list<Structure> structures) {
  double pixels = 0;
  for (const Structure structure : structures) {
    for (const float share : coverage.phases.at(structure)[0]) pixels += static_cast<double>(share);
  }
  return kPixelMm * std::sqrt(pixels / 2 / std::numbers::pi);
}

TEST(Cover, OfAThinWallsOutsideDoesNotHangOnWhereLabelsPutItsCavity) {
  for (const double cavity_mm : {19.0, 20.0, 21.5}) {
    const Covered found = covered(ring(cavity_mm, kOutsideMm));
    EXPECT_NEAR(radius_mm(found.coverage, {Structure::LvBlood, Structure::LvMyocardium}),
                kOutsideMm, 0.15)
        << cavity_mm;
  }
}

TEST(Cover, OfACavityWithoutAWallHoldsNoWall) {
  const Covered found = covered(ring(kCavityMm, kCavityMm));
  EXPECT_EQ(found.coverage.phases.count(Structure::LvBlood), 1U);
  EXPECT_EQ(found.coverage.phases.count(Structure::LvMyocardium), 0U);
  EXPECT_EQ(found.uncertainty.count(Structure::LvMyocardium), 0U);
}

}  // namespace
}  // namespace beatlas::edges::coverage_tests
