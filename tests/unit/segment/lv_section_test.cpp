#include "pipeline/segment/lv_section.h"

#include <cmath>

#include <gtest/gtest.h>

#include "runtime/atlas/structures.h"

namespace beatlas::segment {
namespace {

constexpr int kSide = 80;

/// A ring of muscle of 9 pixels (1.5 mm) about a cavity of a radius of 14, in one of two slices.
ImageCycle<std::uint8_t> ring() {
  ImageCycle<std::uint8_t> out;
  out.grid.size = {kSide, kSide, 2};
  out.grid.mm_from_index.linear() = Vec3(1.5, 1.5, 8).asDiagonal();
  out.phases.emplace_back(out.grid.count(), kLabelBackground);
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const double r = std::hypot(i - 40, j - 30);
      if (r < 23) {
        out.phases[0][out.grid.offset(i, j, 1)] = r < 14 ? kLabelLvBlood : kLabelLvMyocardium;
      }
    }
  }
  return out;
}

/// Three slices of that ring, of which the third is the base's; in the first two the wall is open
/// on one side, in the third all about.
TEST(LvSection, TheWallHasNoHoleBelowTheBase) {
  const ImageCycle<std::uint8_t> one = ring();
  ImageCycle<std::uint8_t> open;
  open.grid = one.grid;
  open.grid.size[2] = 4;
  open.phases.emplace_back(open.grid.count(), kLabelBackground);
  const auto opened = [](int i, int j) { return i > 40 && std::abs(j - 30) < 8; };
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        std::uint8_t label = one.phases[0][one.grid.offset(i, j, 1)];
        if (k != 2 && label == kLabelLvMyocardium && opened(i, j)) {
          label = k == 1 ? kLabelRvBlood : kLabelBackground;
        }
        open.phases[0][open.grid.offset(i, j, k)] = label;
      }
    }
  }
  const auto at = [](const ImageCycle<std::uint8_t>& labels, int i, int j, int k) {
    return labels.phases[0][labels.grid.offset(i, j, k)];
  };
  ImageCycle<std::uint8_t> closed = open;
  close_wall(1, closed);
  for (const int k : {0, 1}) {
    // 2 mm are two pixels of 1.5 mm beside the cavity, which keeps its size.
    EXPECT_EQ(at(closed, 53, 30, k), kLabelLvBlood);
    EXPECT_EQ(at(closed, 54, 30, k), kLabelLvMyocardium);
    EXPECT_EQ(at(closed, 55, 30, k), kLabelLvMyocardium);
    EXPECT_EQ(at(closed, 57, 30, k), at(open, 57, 30, k)) << "no thicker";
    EXPECT_EQ(at(closed, 20, 30, k), at(open, 20, 30, k)) << "where there is a wall";
  }
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      EXPECT_EQ(at(closed, i, j, 2), at(open, i, j, 2));
      EXPECT_EQ(at(closed, i, j, 3), at(open, i, j, 3)) << "the outflow tract is open";
    }
  }
  // With the base on the other side no slice beyond the third lies below a closed one but that.
  ImageCycle<std::uint8_t> other = open;
  close_wall(-1, other);
  EXPECT_EQ(at(other, 54, 30, 0), kLabelBackground);
  EXPECT_EQ(at(other, 54, 30, 3), kLabelLvMyocardium);
}

TEST(LvSection, AStripOnTheWallIsNoneOfIt) {
  const ImageCycle<std::uint8_t> before = ring();
  ImageCycle<std::uint8_t> labels = before;
  // As wide as the wall is thick, away from the ring and on along it, as a stomach's wall.
  for (int j = 48; j < 75; ++j) {
    for (int i = 36; i < 45; ++i) {
      std::uint8_t& label = labels.phases[0][labels.grid.offset(i, j, 1)];
      if (label == kLabelBackground) label = kLabelLvMyocardium;
    }
  }
  trim_wall(labels);
  int more = 0;
  for (std::size_t v = 0; v < labels.phases[0].size(); ++v) {
    if (before.phases[0][v] != kLabelBackground) {
      EXPECT_EQ(labels.phases[0][v], before.phases[0][v]);
    }
    more += labels.phases[0][v] != before.phases[0][v] ? 1 : 0;
  }
  EXPECT_LT(more, 9 * 3);  // of 22 rows the corners between ring and strip
}

TEST(LvSection, ARingAnOpenRingAndACapStay) {
  ImageCycle<std::uint8_t> labels = ring();
  // Beyond the mitral valve: a quarter of the wall is missing, the cavity is there.
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      std::uint8_t& label = labels.phases[0][labels.grid.offset(i, j, 1)];
      if (i > 40 && j > 30 && label == kLabelLvMyocardium) label = kLabelBackground;
      // The apex: muscle alone.
      if (std::hypot(i - 40, j - 30) < 6) {
        labels.phases[0][labels.grid.offset(i, j, 0)] = kLabelLvMyocardium;
      }
    }
  }
  const ImageCycle<std::uint8_t> before = labels;
  trim_wall(labels);
  int lost = 0;
  for (std::size_t v = 0; v < labels.phases[0].size(); ++v) {
    lost += labels.phases[0][v] != before.phases[0][v] ? 1 : 0;
  }
  // Where the ring ends a disc of half its radius leaves two corners, (1 - pi / 4) r^2 each.
  EXPECT_LT(lost, 2 * 0.215 * 11.5 * 11.5);
}

TEST(LvSection, WithoutAnLvNothingHappens) {
  ImageCycle<std::uint8_t> labels = ring();
  for (std::uint8_t& label : labels.phases[0]) {
    if (label != kLabelBackground) label = kLabelRvBlood;
  }
  const std::vector<std::uint8_t> before = labels.phases[0];
  trim_wall(labels);
  EXPECT_EQ(labels.phases[0], before);
}

}  // namespace
}  // namespace beatlas::segment
