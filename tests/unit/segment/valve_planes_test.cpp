/// Where ventricles of thick slices end, on made labels.
#include "pipeline/segment/valve_planes.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/atlas/structures.h"
#include "tests/made_images.h"

namespace beatlas::segment::valve_planes_tests {
namespace {

constexpr int kSlices = 8;

/// An LV in slices 1 to last[p], whose slice 2 holds as much as each phase says.
ImageCycle<std::uint8_t> beating(const std::vector<int>& last, const std::vector<int>& voxels) {
  ImageCycle<std::uint8_t> labels;
  labels.grid = made::straight_grid({40, 40, kSlices}, {1.5, 1.5, 10});
  for (std::size_t p = 0; p < last.size(); ++p) {
    std::vector<std::uint8_t>& phase =
        labels.phases.emplace_back(labels.grid.count(), kLabelBackground);
    for (int k = 1; k <= last[p]; ++k) {
      const auto from = phase.begin() + static_cast<std::ptrdiff_t>(labels.grid.offset(0, 0, k));
      std::fill_n(from, k == 2 ? voxels[p] : 1, kLabelLvBlood);
    }
  }
  return labels;
}

std::vector<double> ends_of(const ImageCycle<std::uint8_t>& labels) {
  return estimated_valve_planes(labels, 1).at(Structure::LvBlood).k;
}

TEST(ValvePlanes, ABaseThatLeapsOverASliceDescendsAsTheVentricleEmpties) {
  // The base passes the middle of slice 6 half-way.
  const std::vector<double> ends =
      ends_of(beating({6, 6, 6, 5, 5, 5, 5, 6, 6}, {1000, 900, 800, 700, 600, 500, 600, 800, 900}));
  EXPECT_NEAR(0.5 * (ends[2] + ends[3]), 6, 0.1);
  for (std::size_t p = 1; p < 6; ++p) EXPECT_LT(ends[p], ends[p - 1]) << p;
  EXPECT_EQ(ends[4], ends[6]);
  // Its way is told no better than that it stays between two slices on either side; the mean of
  // what it may be.
  EXPECT_GT(ends[0] - ends[5], 0.5);
  EXPECT_LT(ends[0] - ends[5], 1.6);
  for (std::size_t p = 0; p < ends.size(); ++p) {
    const bool full = p < 3 || p > 6;
    EXPECT_GE(ends[p], full ? 6 : 5) << p;
    EXPECT_LE(ends[p], full ? 7 : 6) << p;
  }
}

TEST(ValvePlanes, ABaseThatLeavesNoSliceStaysBetweenTwo) {
  for (const double end : ends_of(beating({6, 6, 6, 6}, {1000, 700, 400, 700}))) {
    EXPECT_GE(end, 6);
    EXPECT_LE(end, 7);
  }
}

TEST(ValvePlanes, OfLabelsThatNoBaseCouldLeaveEachPhaseHasAnEnd) {
  std::vector<int> last;
  std::vector<int> voxels;
  for (int p = 0; p < 60; ++p) {
    last.push_back(p % 2 == 0 ? 2 : 7);
    voxels.push_back(500 + (p * 37) % 101);
  }
  const std::vector<double> ends = ends_of(beating(last, voxels));
  for (std::size_t p = 0; p < ends.size(); ++p) {
    ASSERT_TRUE(std::isfinite(ends[p])) << p;
    EXPECT_NEAR(ends[p], last[p] + 0.5, 0.5) << p;
  }
}

}  // namespace
}  // namespace beatlas::segment::valve_planes_tests
