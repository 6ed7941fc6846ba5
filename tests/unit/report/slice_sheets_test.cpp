#include "pipeline/report/slice_sheets.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "runtime/base/error.h"

namespace beatlas::report::slice_sheets_tests {
namespace {

constexpr int kSize = 40;
constexpr double kRadius = 9.3;
const Vec2 kCentre(18.4, 20.7);

/// Share of a voxel that lies in the disc, from 32 x 32 points of it.
float share_in_disc(int i, int j) {
  constexpr int kParts = 32;
  int inside = 0;
  for (int a = 0; a < kParts; ++a) {
    for (int b = 0; b < kParts; ++b) {
      const Vec2 x(i - 0.5 + (a + 0.5) / kParts, j - 0.5 + (b + 0.5) / kParts);
      if ((x - kCentre).norm() < kRadius) ++inside;
    }
  }
  return static_cast<float>(inside) / (kParts * kParts);
}

struct Made {
  Cine cine;
  Segmentation segmentation;
};

/// Two phases of three slices; the disc lies in slice 1 of phase 0 and brightens the image there.
Made disc() {
  Made out;
  Grid grid{{kSize, kSize, 3}, Affine::Identity()};
  grid.mm_from_index.linear() = Vec3(1, 1, 8).asDiagonal();
  out.cine.images = {grid, {2, std::vector<float>(grid.count(), 10.0F)}};
  out.cine.rr_interval_s = 0.8;
  out.segmentation.labels = {grid, {2, std::vector<std::uint8_t>(grid.count(), 0)}};
  out.segmentation.coverage.grid = grid.part({4, 5, 0}, {32, 33, 3});
  out.segmentation.coverage.first = {4, 5, 0};
  auto& phases = out.segmentation.coverage.phases[Structure::LvBlood];
  phases.assign(2, std::vector<float>(out.segmentation.coverage.grid.count(), 0.0F));
  for (int j = 0; j < 33; ++j) {
    for (int i = 0; i < 32; ++i) {
      const float share = share_in_disc(i + 4, j + 5);
      phases[0][out.segmentation.coverage.grid.offset(i, j, 1)] = share;
      out.cine.images.phases[0][grid.offset(i + 4, j + 5, 1)] += 200 * share;
    }
  }
  return out;
}

TEST(Outlines, LieOnTheCircleBetweenVoxels) {
  const Made made = disc();
  const auto lines = outlines(made.segmentation, Structure::LvBlood, 0, 1, 0);
  ASSERT_EQ(lines.size(), 1U);
  double area = 0;
  for (std::size_t p = 0; p < lines[0].size(); ++p) {
    const auto& a = lines[0][p];
    const auto& b = lines[0][(p + 1) % lines[0].size()];
    area += 0.5 * (double(a[0]) * b[1] - double(b[0]) * a[1]);
    // Half coverage, linear between voxels, lies within a tenth of a voxel of a circle of nine.
    EXPECT_NEAR((Vec2(a[0], a[1]) - kCentre).norm(), kRadius, 0.1);
  }
  // A chord in place of an arc lacks a little everywhere: 0.03 voxels of the radius.
  EXPECT_NEAR(std::abs(area), std::numbers::pi * kRadius * kRadius,
              2 * std::numbers::pi * kRadius * 0.03);
}

TEST(Outlines, AreThinnedToTheTolerance) {
  const Made made = disc();
  const auto whole = outlines(made.segmentation, Structure::LvBlood, 0, 1, 0);
  const auto thin = outlines(made.segmentation, Structure::LvBlood, 0, 1, 0.2);
  ASSERT_EQ(thin.size(), 1U);
  EXPECT_LT(thin[0].size(), whole[0].size() / 2);
  for (const auto& x : thin[0]) {
    EXPECT_NEAR((Vec2(x[0], x[1]) - kCentre).norm(), kRadius, 0.1);
  }
}

TEST(Outlines, AreNoneWhereNothingIs) {
  Made made = disc();
  EXPECT_TRUE(outlines(made.segmentation, Structure::LvBlood, 1, 1, 0).empty());
  EXPECT_TRUE(outlines(made.segmentation, Structure::LvBlood, 0, 0, 0).empty());
  EXPECT_TRUE(outlines(made.segmentation, Structure::Heart, 0, 1, 0).empty());
  // What a slice shows stays, wherever a valve's plane is thought to be.
  made.segmentation.valve_planes[Structure::LvBlood] = {+1, {0.6, 0.6}};
  EXPECT_FALSE(outlines(made.segmentation, Structure::LvBlood, 0, 1, 0).empty());
}

TEST(Outlines, OfDiagonalVoxelsAreClosedLinesApart) {
  Made made = disc();
  auto& voxels = made.segmentation.coverage.phases[Structure::LvBlood][1];
  const Grid& grid = made.segmentation.coverage.grid;
  voxels[grid.offset(10, 10, 0)] = voxels[grid.offset(11, 11, 0)] = 1;
  voxels[grid.offset(0, 0, 0)] = 1;  // at the rim of the coverage's part
  const auto lines = outlines(made.segmentation, Structure::LvBlood, 1, 0, 0);
  ASSERT_EQ(lines.size(), 3U);
  for (const auto& line : lines) EXPECT_EQ(line.size(), 4U);
}

TEST(PackedOutlines, GiveTheLinesBack) {
  const Made made = disc();
  const SliceSheets sheets = slice_sheets(made.cine, &made.segmentation, {});
  const auto packed = packed_outlines(made.segmentation, {Structure::LvBlood}, 1, sheets, 0.1);
  const auto lines = outlines(made.segmentation, Structure::LvBlood, 0, 1, 0.1);
  const auto word = [&](std::size_t at) {
    return static_cast<std::int16_t>(packed.at(2 * at) | (packed.at(2 * at + 1) << 8));
  };
  ASSERT_EQ(word(0), 1);
  ASSERT_EQ(static_cast<std::size_t>(word(1)), lines[0].size());
  for (std::size_t p = 0; p < lines[0].size(); ++p) {
    EXPECT_NEAR(word(2 + 2 * p) / 32.0 + sheets.first_i, lines[0][p][0], 1.0 / 64 + 1e-4);
    EXPECT_NEAR(word(3 + 2 * p) / 32.0 + sheets.first_j, lines[0][p][1], 1.0 / 64 + 1e-4);
  }
  const std::size_t end = 2 + 2 * lines[0].size();
  EXPECT_EQ(word(end), 0) << "the second phase has none";
  EXPECT_EQ(packed.size(), 2 * (end + 1));
}

TEST(SliceSheets, ShowThePhasesOfTheHeartSideBySide) {
  const Made made = disc();
  const SliceSheets sheets = slice_sheets(made.cine, &made.segmentation, {});
  ASSERT_EQ(sheets.jpeg.size(), 3U);
  EXPECT_EQ(sheets.columns, 2);
  EXPECT_EQ(sheets.tile_width % 8, 0);
  EXPECT_GE(sheets.tile_width, sheets.width);
  const cv::Mat sheet = cv::imdecode(sheets.jpeg[1], cv::IMREAD_GRAYSCALE);
  ASSERT_EQ(sheet.cols, 2 * sheets.tile_width);
  const int x = static_cast<int>(kCentre.x()) - sheets.first_i;
  const int y = static_cast<int>(kCentre.y()) - sheets.first_j;
  EXPECT_GT(sheet.at<std::uint8_t>(y, x), 200);
  EXPECT_LT(sheet.at<std::uint8_t>(y, x + sheets.tile_width), 60);
}

TEST(SliceSheets, HoldEveryPlaceAndKeepTheirBytes) {
  Made made = disc();
  std::uint32_t random = 1;
  for (auto& phase : made.cine.images.phases) {
    for (float& voxel : phase)
      voxel += static_cast<float>((random = random * 1664525 + 1013904223) >> 24);
  }
  const SliceSheets whole = slice_sheets(made.cine, &made.segmentation, {}, {2, 1'000'000, 0});
  const SliceSheets wider =
      slice_sheets(made.cine, &made.segmentation, {{38, 2, 8}}, {2, 1'000'000, 0});
  EXPECT_GT(wider.first_i + wider.width, 38);
  EXPECT_LE(wider.first_j, 2);
  EXPECT_GT(wider.width, whole.width);
  std::size_t bytes = 0;
  for (const auto& jpeg : whole.jpeg) bytes += jpeg.size();
  const SliceSheets small = slice_sheets(made.cine, &made.segmentation, {}, {2, bytes / 2, 0});
  std::size_t fewer = 0;
  for (const auto& jpeg : small.jpeg) fewer += jpeg.size();
  EXPECT_LE(fewer, bytes / 2);
  EXPECT_LT(small.quality, whole.quality);
}

TEST(SliceSheets, RefuseImagesOfAnotherSize) {
  Made made = disc();
  made.cine.images.phases[1].pop_back();
  EXPECT_THROW((void)slice_sheets(made.cine, &made.segmentation, {}), Error);
}

}  // namespace
}  // namespace beatlas::report::slice_sheets_tests
