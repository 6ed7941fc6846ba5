/// Smoothed outlines of cavities against their areas.
#include "pipeline/segment/smooth_outlines.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/atlas/structures.h"
#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

constexpr double kPixelSideMm = 1.5;

/// One slice in which a crescent as a right ventricle's, 12 mm wide at most, is `label`, with every
/// 13th pixel of its rim left out or added.
ImageCycle<std::uint8_t> ragged_crescent(std::uint8_t label) {
  const Grid grid = made::straight_grid({60, 60, 1}, {kPixelSideMm, kPixelSideMm, 8});
  ImageCycle<std::uint8_t> out{grid, {std::vector<std::uint8_t>(grid.count(), kLabelBackground)}};
  for (int j = 0; j < 60; ++j) {
    for (int i = 0; i < 60; ++i) {
      const Vec2 at(kPixelSideMm * (i - 30), kPixelSideMm * (j - 30));
      const double out_of_outer = at.norm() - 30;
      const double into_inner = 27 - (at - Vec2(-9, 0)).norm();
      const double beyond = std::max(out_of_outer, into_inner);
      bool inside = beyond < 0;
      if (std::abs(beyond) < kPixelSideMm && (7 * i + 3 * j) % 13 == 0) inside = !inside;
      if (inside) out.phases[0][grid.offset(i, j, 0)] = label;
    }
  }
  return out;
}

long area(const ImageCycle<std::uint8_t>& labels, std::uint8_t label) {
  return std::count(labels.phases[0].begin(), labels.phases[0].end(), label);
}

/// Faces of pixels between the label and what is none.
int rim(const ImageCycle<std::uint8_t>& labels, std::uint8_t label) {
  const Grid& grid = labels.grid;
  int faces = 0;
  for (int j = 0; j + 1 < grid.size[1]; ++j) {
    for (int i = 0; i + 1 < grid.size[0]; ++i) {
      const auto is = [&](int x, int y) { return labels.phases[0][grid.offset(x, y, 0)] == label; };
      faces +=
          static_cast<int>(is(i, j) != is(i + 1, j)) + static_cast<int>(is(i, j) != is(i, j + 1));
    }
  }
  return faces;
}

TEST(SmoothOutlines, ACrescentKeepsItsAreaAndLosesItsRaggedRim) {
  for (const std::uint8_t label : {kLabelRvBlood, kLabelRaBlood, kLabelAorta}) {
    ImageCycle<std::uint8_t> labels = ragged_crescent(label);
    const long before = area(labels, label);
    const int ragged = rim(labels, label);
    smooth_outlines(labels, 2);
    EXPECT_NEAR(static_cast<double>(area(labels, label)), static_cast<double>(before), 2)
        << int{label};
    EXPECT_LT(rim(labels, label), 0.9 * ragged) << int{label};
  }
}

TEST(SmoothOutlines, SpecksAreLostAndGiveACavityNothing) {
  ImageCycle<std::uint8_t> labels = ragged_crescent(kLabelRvBlood);
  ImageCycle<std::uint8_t> specked = labels;
  for (int n = 0; n < 60; n += 3) specked.phases[0][labels.grid.offset(n, 2, 0)] = kLabelRvBlood;
  smooth_outlines(labels, 2);
  smooth_outlines(specked, 2);
  EXPECT_EQ(specked.phases[0], labels.phases[0]);
}

TEST(SmoothOutlines, WhatFillsTheSliceStays) {
  ImageCycle<std::uint8_t> labels = ragged_crescent(kLabelRvBlood);
  std::fill(labels.phases[0].begin(), labels.phases[0].end(), kLabelRvBlood);
  smooth_outlines(labels, 2);
  EXPECT_EQ(area(labels, kLabelRvBlood), 3600);
}

}  // namespace
}  // namespace beatlas::segment
