#include "pipeline/ingest/slice_resampling.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace beatlas::ingest::slice_resampling_tests {
namespace {

Grid stack_grid() {
  Grid grid;
  grid.size = {40, 30, 3};
  grid.mm_from_index.linear() = Vec3(1.5, 1.2, 8).asDiagonal();
  grid.mm_from_index.translation() = Vec3(-20, 10, 5);
  return grid;
}

/// An image of slice 1 on the stack's own pixels.
DicomImage own_image(const Grid& grid) {
  DicomImage image;
  image.columns = grid.size[0];
  image.rows = grid.size[1];
  image.column_step_mm = grid.spacing_mm()[0];
  image.row_step_mm = grid.spacing_mm()[1];
  image.position_lps = grid.mm(0, 0, 1);
  return image;
}

/// What the image shows of a field over the patient.
template <class Field>
std::vector<float> shown(const DicomImage& image, const Field& field) {
  std::vector<float> out;
  for (int j = 0; j < image.rows; ++j) {
    for (int i = 0; i < image.columns; ++i) {
      out.push_back(static_cast<float>(
          field(Vec3(image.position_lps + image.row_lps * (i * image.column_step_mm) +
                     image.column_lps * (j * image.row_step_mm)))));
    }
  }
  return out;
}

TEST(SliceResampling, KnowsTheStacksOwnPixels) {
  const Grid grid = stack_grid();
  DicomImage image = own_image(grid);
  EXPECT_TRUE(SliceResampling(image, grid, 1).same());
  EXPECT_TRUE(SliceResampling(image, grid, 1).shows_middle());
  image.position_lps.x() += 0.09 * 1.5;
  EXPECT_TRUE(SliceResampling(image, grid, 1).same());
  image.position_lps.x() += 0.03 * 1.5;
  EXPECT_FALSE(SliceResampling(image, grid, 1).same());
  image = own_image(grid);
  image.columns = 41;
  EXPECT_FALSE(SliceResampling(image, grid, 1).same());
  image = own_image(grid);
  image.column_step_mm *= 1.01;
  EXPECT_FALSE(SliceResampling(image, grid, 1).same());
}

// Cubic convolution repeats a straight slope exactly, and a parabola within an image.
TEST(SliceResampling, RepeatsAStraightSlopeHoweverTheImageLies) {
  const Grid grid = stack_grid();
  const auto slope = [](const Vec3& at) { return 300 + 2 * at.x() - 3 * at.y(); };
  for (const double degrees : {0.0, 7.0, 90.0, 180.0, -63.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    DicomImage image;
    image.columns = 100;
    image.rows = 90;
    image.column_step_mm = 1.1;
    image.row_step_mm = 1.3;
    image.row_lps = Vec3(std::cos(angle), std::sin(angle), 0);
    image.column_lps = Vec3(-std::sin(angle), std::cos(angle), 0);
    const Vec3 middle = grid.mm(19.5, 14.5, 1);
    image.position_lps = middle - image.row_lps * 54 - image.column_lps * 57;
    const SliceResampling onto(image, grid, 1);
    EXPECT_FALSE(onto.same());
    EXPECT_TRUE(onto.shows_middle());
    EXPECT_NEAR(onto.turn_deg(), 0, 1e-5);
    std::vector<float> out(grid.slice_count());
    onto.resample(shown(image, slope), out);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        EXPECT_NEAR(out[grid.offset(i, j, 0)], slope(grid.mm(i, j, 1)), 1e-3) << degrees;
      }
    }
  }
}

// Looked at from the other side: rows run the same way, columns the other.
TEST(SliceResampling, OfAnImageThatFacesTheOtherWayIsTurnedNotMirrored) {
  const Grid grid = stack_grid();
  DicomImage image = own_image(grid);
  image.position_lps = grid.mm(0, grid.size[1] - 1, 1);
  image.column_lps = -Vec3::UnitY();
  const auto slope = [](const Vec3& at) { return 300 + 2 * at.x() - 3 * at.y(); };
  std::vector<float> out(grid.slice_count());
  const SliceResampling onto(image, grid, 1);
  onto.resample(shown(image, slope), out);
  EXPECT_NEAR(out.front(), slope(grid.mm(0, 0, 1)), 1e-3);
  EXPECT_NEAR(out.back(), slope(grid.mm(39, 29, 1)), 1e-3);
  EXPECT_NEAR(onto.turn_deg(), 0, 1e-5);
}

// What is seen along the stack's normal is what lies on the plane there.
TEST(SliceResampling, OfATurnedSliceIsSeenAlongTheNormal) {
  const Grid grid = stack_grid();
  DicomImage image = own_image(grid);
  const double angle = 2 * std::numbers::pi / 180;
  const Vec3 middle = grid.mm(0, 14.5, 1);
  image.column_lps = Vec3(0, std::cos(angle), std::sin(angle));
  image.rows = 34;
  image.position_lps = middle - image.column_lps * (16.5 * image.row_step_mm);
  const auto slope = [](const Vec3& at) { return 300 + 2 * at.x() - 3 * at.y(); };  // none along z
  std::vector<float> out(grid.slice_count());
  const SliceResampling onto(image, grid, 1);
  EXPECT_NEAR(onto.turn_deg(), 2, 1e-9);
  onto.resample(shown(image, slope), out);
  EXPECT_NEAR(out.front(), slope(grid.mm(0, 0, 1)), 1e-3);
  EXPECT_NEAR(out.back(), slope(grid.mm(39, 29, 1)), 1e-3);
}

TEST(SliceResampling, BeyondTheImageIsAsDarkAsItsDarkestPixel) {
  const Grid grid = stack_grid();
  DicomImage image = own_image(grid);
  image.position_lps.x() += 15;  // ten columns
  const SliceResampling onto(image, grid, 1);
  EXPECT_FALSE(onto.shows_middle());
  EXPECT_NEAR(onto.shift_mm(), 15, 1e-9);
  std::vector<float> own(grid.slice_count(), 50);
  own[3] = 7;
  std::vector<float> out(grid.slice_count());
  onto.resample(own, out);
  EXPECT_EQ(out[grid.offset(9, 12, 0)], 7);
  EXPECT_EQ(out[grid.offset(10, 12, 0)], 50);
  EXPECT_EQ(out[grid.offset(13, 0, 0)], 7);
}

TEST(SliceResampling, KnowsWhetherItShowsTheMiddleHalf) {
  const Grid grid = stack_grid();  // 40 columns: the middle half begins 9.75 behind the first
  DicomImage image = own_image(grid);
  image.position_lps.x() += 9.7 * 1.5;
  EXPECT_TRUE(SliceResampling(image, grid, 1).shows_middle());
  image.position_lps.x() += 0.1 * 1.5;
  EXPECT_FALSE(SliceResampling(image, grid, 1).shows_middle());
  // A small field about the same middle.
  image = own_image(grid);
  image.columns = 22;
  image.rows = 17;
  image.position_lps = grid.mm(9, 6.5, 1);
  EXPECT_TRUE(SliceResampling(image, grid, 1).shows_middle());
  EXPECT_NEAR(SliceResampling(image, grid, 1).shift_mm(), 0, 1e-9);
}

TEST(SliceResampling, MakesNothingBrighterOrDarkerThanItWas) {
  const Grid grid = stack_grid();
  DicomImage image = own_image(grid);
  image.position_lps += Vec3(0.6, 0.5, 0);
  std::vector<float> own(grid.slice_count(), 0);
  for (std::size_t v = 0; v < own.size(); ++v) own[v] = v % 40 < 20 ? 0 : 1000;
  std::vector<float> out(grid.slice_count());
  SliceResampling(image, grid, 1).resample(own, out);
  for (const float value : out) {
    EXPECT_GE(value, 0);
    EXPECT_LE(value, 1000);
  }
}

}  // namespace
}  // namespace beatlas::ingest::slice_resampling_tests
