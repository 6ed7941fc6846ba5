/// What hangs together, on made labels.
#include "pipeline/segment/connected.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/atlas/structures.h"
#include "tests/made_images.h"

namespace beatlas::segment {
namespace {

void fill(ImageCycle<std::uint8_t>& labels, std::size_t phase, const Index3& low,
          const Index3& high, std::uint8_t label) {
  for (int k = low[2]; k <= high[2]; ++k) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) {
        labels.phases[phase][labels.grid.offset(i, j, k)] = label;
      }
    }
  }
}

std::ptrdiff_t count_of(const ImageCycle<std::uint8_t>& labels, std::size_t phase,
                        std::uint8_t label) {
  return std::count(labels.phases[phase].begin(), labels.phases[phase].end(), label);
}

ImageCycle<std::uint8_t> cycle_of(double slice_mm) {
  ImageCycle<std::uint8_t> labels;
  labels.grid = made::straight_grid({20, 20, 10}, {1.4, 1.4, slice_mm});
  labels.phases.assign(2, std::vector<std::uint8_t>(labels.grid.count(), kLabelBackground));
  return labels;
}

TEST(Connected, AFilmOfFatBeyondTheWallIsNoVentricle) {
  for (const double slice_mm : {3.0, 10.0}) {
    ImageCycle<std::uint8_t> labels = cycle_of(slice_mm);
    for (std::size_t p = 0; p < 2; ++p) {
      fill(labels, p, {3, 3, 2}, {14, 14, 8}, kLabelRestOfHeart);
      fill(labels, p, {6, 6, 4}, {12, 12, 7}, kLabelRvBlood);
    }
    // Below the wall of one slice; and beside it, touching by an edge alone.
    fill(labels, 1, {6, 6, 2}, {10, 8, 2}, kLabelRvBlood);
    fill(labels, 1, {5, 6, 3}, {5, 12, 3}, kLabelRvBlood);
    keep_largest({kLabelRvBlood}, kLabelRestOfHeart, labels);
    for (std::size_t p = 0; p < 2; ++p) {
      EXPECT_EQ(count_of(labels, p, kLabelRvBlood), 7 * 7 * 4) << slice_mm;
      EXPECT_EQ(count_of(labels, p, kLabelRvBlood) + count_of(labels, p, kLabelRestOfHeart),
                12 * 12 * 7);
    }
  }
}

TEST(Connected, WhatTouchesTheHeartInAnotherPhaseAloneIsAnotherBody) {
  ImageCycle<std::uint8_t> labels = cycle_of(3);
  for (std::size_t p = 0; p < 2; ++p) fill(labels, p, {3, 3, 2}, {9, 9, 7}, kLabelRestOfHeart);
  fill(labels, 0, {10, 5, 4}, {13, 6, 5}, kLabelRestOfHeart);  // joins
  fill(labels, 1, {12, 5, 4}, {13, 6, 5}, kLabelRestOfHeart);  // joins through time alone
  fill(labels, 1, {16, 15, 8}, {17, 16, 9}, kLabelRestOfHeart);
  keep_connected_heart(labels);
  EXPECT_EQ(count_of(labels, 0, kLabelRestOfHeart), 7 * 7 * 6 + 4 * 2 * 2);
  EXPECT_EQ(count_of(labels, 1, kLabelRestOfHeart), 7 * 7 * 6);
}

/// Voxels of all phases in their parts, each named by the least node of it, by telling neighbours
/// again and again.
std::vector<std::size_t> parts_by_telling(const ImageCycle<std::uint8_t>& labels) {
  const std::size_t count = labels.grid.count();
  const std::size_t phases = labels.phases.size();
  const auto [nx, ny, nz] = labels.grid.size;
  const std::size_t none = count * phases;
  std::vector<std::size_t> part(count * phases, none);
  for (std::size_t node = 0; node < part.size(); ++node) {
    if (labels.phases[node / count][node % count] != kLabelBackground) part[node] = node;
  }
  for (bool changed = true; changed;) {
    changed = false;
    const auto tell = [&](std::size_t a, std::size_t b) {
      if (part[a] == none || part[b] == none || part[a] == part[b]) return;
      part[a] = part[b] = std::min(part[a], part[b]);
      changed = true;
    };
    for (std::size_t p = 0; p < phases; ++p) {
      for (int k = 0; k < nz; ++k) {
        for (int j = 0; j < ny; ++j) {
          for (int i = 0; i < nx; ++i) {
            const std::size_t at = p * count + labels.grid.offset(i, j, k);
            if (i + 1 < nx) tell(at, p * count + labels.grid.offset(i + 1, j, k));
            if (j + 1 < ny) tell(at, p * count + labels.grid.offset(i, j + 1, k));
            if (k + 1 < nz) tell(at, p * count + labels.grid.offset(i, j, k + 1));
            tell(at, (p + 1) % phases * count + labels.grid.offset(i, j, k));
          }
        }
      }
    }
  }
  return part;
}

TEST(Connected, OfScatteredVoxelsThoseOfTheLargestPartStay) {
  std::mt19937 random(7);
  for (const unsigned share : {20U, 25U, 40U}) {
    ImageCycle<std::uint8_t> labels;
    labels.grid = made::straight_grid({11, 9, 7}, {1, 1, 1});
    labels.phases.assign(4, std::vector<std::uint8_t>(labels.grid.count(), kLabelBackground));
    for (auto& phase : labels.phases) {
      for (std::uint8_t& label : phase) {
        if (random() % 100 < share) label = kLabelRestOfHeart;
      }
    }
    const std::vector<std::size_t> part = parts_by_telling(labels);
    std::vector<std::size_t> voxels(part.size() + 1, 0);
    for (const std::size_t of : part) ++voxels[of];
    const auto largest = static_cast<std::size_t>(
        std::max_element(voxels.begin(), voxels.end() - 1) - voxels.begin());
    ASSERT_LT(voxels[largest], part.size() - voxels.back()) << "there is but one part";
    keep_largest({kLabelRestOfHeart}, kLabelBackground, labels);
    const std::size_t count = labels.grid.count();
    for (std::size_t node = 0; node < part.size(); ++node) {
      ASSERT_EQ(labels.phases[node / count][node % count] != kLabelBackground,
                part[node] == largest)
          << share << " % held, node " << node;
    }
  }
}

TEST(Connected, TheCavityInMuscleStaysWhereAnAtriumIsTheLargerPart) {
  ImageCycle<std::uint8_t> labels = cycle_of(8);
  for (std::size_t p = 0; p < 2; ++p) {
    fill(labels, p, {4, 4, 0}, {12, 12, 4}, kLabelLvMyocardium);
    fill(labels, p, {7, 7, 1}, {9, 9, 4}, kLabelLvBlood);
    // Beyond a slice between them, beside a rest of the ring on one side.
    fill(labels, p, {4, 4, 6}, {14, 14, 8}, kLabelLvBlood);
    fill(labels, p, {3, 4, 6}, {3, 8, 6}, kLabelLvMyocardium);
  }
  keep_stacked(kLabelLvBlood, kLabelLvMyocardium, kLabelRestOfHeart, labels);
  for (std::size_t p = 0; p < 2; ++p) {
    EXPECT_EQ(count_of(labels, p, kLabelLvBlood), 3 * 3 * 4);
    EXPECT_EQ(count_of(labels, p, kLabelRestOfHeart), 11 * 11 * 3);
  }
}

TEST(Connected, SectionsOfAVentricleLieOverEachOther) {
  ImageCycle<std::uint8_t> labels = cycle_of(8);
  for (std::size_t p = 0; p < 2; ++p) {
    fill(labels, p, {4, 4, 1}, {13, 13, 4}, kLabelLvMyocardium);
    fill(labels, p, {6, 6, 2}, {11, 11, 4}, kLabelLvBlood);
    fill(labels, p, {8, 8, 1}, {9, 9, 1}, kLabelLvBlood);    // narrower at the apex
    fill(labels, p, {9, 6, 5}, {14, 11, 5}, kLabelLvBlood);  // leans by half
  }
  // In one phase alone it reaches on by an edge of what lies beside it in the slice beyond, which
  // in the other phase nothing holds.
  for (std::size_t p = 0; p < 2; ++p) fill(labels, p, {2, 6, 6}, {8, 11, 6}, kLabelLvBlood);
  fill(labels, 0, {9, 6, 6}, {9, 11, 6}, kLabelLvBlood);
  keep_stacked(kLabelLvBlood, kLabelLvMyocardium, kLabelRestOfHeart, labels);
  for (std::size_t p = 0; p < 2; ++p) {
    EXPECT_EQ(count_of(labels, p, kLabelLvBlood), 2 * 2 + 6 * 6 * 4);
  }
  EXPECT_EQ(count_of(labels, 0, kLabelRestOfHeart), 8 * 6);
  EXPECT_EQ(count_of(labels, 1, kLabelRestOfHeart), 7 * 6);
}

TEST(Connected, AVentricleHasNoGapBetweenItsSections) {
  ImageCycle<std::uint8_t> labels = cycle_of(8);
  for (std::size_t p = 0; p < 2; ++p) {
    fill(labels, p, {4, 4, 1}, {13, 13, 4}, kLabelLvMyocardium);
    fill(labels, p, {6, 6, 1}, {11, 11, 7}, kLabelLvBlood);
  }
  fill(labels, 1, {6, 6, 5}, {11, 11, 5}, kLabelRestOfHeart);  // at end-systole
  keep_stacked(kLabelLvBlood, kLabelLvMyocardium, kLabelRestOfHeart, labels);
  EXPECT_EQ(count_of(labels, 0, kLabelLvBlood), 6 * 6 * 7);
  EXPECT_EQ(count_of(labels, 1, kLabelLvBlood), 6 * 6 * 4);
}

TEST(Connected, WallThatClosesUponACavityLeavesWhatIsBeyondIt) {
  ImageCycle<std::uint8_t> labels = cycle_of(8);
  for (std::size_t p = 0; p < 2; ++p) {
    fill(labels, p, {4, 4, 1}, {13, 13, 6}, kLabelLvMyocardium);
    fill(labels, p, {6, 6, 1}, {11, 11, 6}, kLabelLvBlood);
  }
  // At end-systole no cavity is seen in two slices in the middle, but a pocket at the apex is.
  fill(labels, 1, {6, 6, 1}, {11, 11, 4}, kLabelLvMyocardium);
  fill(labels, 1, {8, 8, 1}, {9, 9, 2}, kLabelLvBlood);
  const ImageCycle<std::uint8_t> before = labels;
  keep_stacked(kLabelLvBlood, kLabelLvMyocardium, kLabelRestOfHeart, labels);
  EXPECT_EQ(labels.phases, before.phases);
}

TEST(Connected, APoolBeyondTheWallOfTheApexIsNoPocket) {
  ImageCycle<std::uint8_t> labels = cycle_of(8);
  for (std::size_t p = 0; p < 2; ++p) {
    fill(labels, p, {4, 4, 2}, {13, 13, 7}, kLabelLvMyocardium);
    fill(labels, p, {6, 6, 3}, {11, 11, 7}, kLabelLvBlood);
    fill(labels, p, {6, 6, 1}, {11, 11, 1}, kLabelLvBlood);
  }
  fill(labels, 0, {6, 6, 2}, {11, 11, 2}, kLabelLvBlood);  // so that it hangs together in one phase
  keep_stacked(kLabelLvBlood, kLabelLvMyocardium, kLabelRestOfHeart, labels);
  EXPECT_EQ(count_of(labels, 1, kLabelLvBlood), 6 * 6 * 5);
  EXPECT_EQ(count_of(labels, 1, kLabelRestOfHeart), 6 * 6);
}

TEST(Connected, ACapOfWallBetweenAVentricleAndAStrayPieceClosesUponNothing) {
  // Towards either end of the stack.
  for (const bool up : {false, true}) {
    ImageCycle<std::uint8_t> labels = cycle_of(8);
    const auto put = [&](std::size_t p, std::array<int, 3> low, std::array<int, 3> high,
                         std::uint8_t label) {
      if (up) {
        const int bottom = 7 - high[2];
        high[2] = 7 - low[2];
        low[2] = bottom;
      }
      fill(labels, p, low, high, label);
    };
    for (std::size_t p = 0; p < 2; ++p) {
      put(p, {4, 4, 2}, {13, 13, 7}, kLabelLvMyocardium);
      put(p, {6, 6, 2}, {11, 11, 7}, kLabelLvBlood);
      put(p, {7, 7, 0}, {9, 9, 0}, kLabelLvBlood);
    }
    put(0, {6, 6, 1}, {11, 11, 1}, kLabelLvBlood);
    put(1, {7, 7, 1}, {9, 9, 1}, kLabelLvMyocardium);  // at end-systole
    keep_stacked(kLabelLvBlood, kLabelLvMyocardium, kLabelRestOfHeart, labels);
    EXPECT_EQ(count_of(labels, 0, kLabelLvBlood), 6 * 6 * 7 + 3 * 3) << up;
    EXPECT_EQ(count_of(labels, 1, kLabelLvBlood), 6 * 6 * 6) << up;
  }
}

TEST(Connected, WallThatSurroundsNothingOfItsVentricleIsNone) {
  ImageCycle<std::uint8_t> labels = cycle_of(8);
  for (std::size_t p = 0; p < 2; ++p) {
    fill(labels, p, {4, 4, 1}, {12, 12, 5}, kLabelLvMyocardium);
    fill(labels, p, {6, 6, 2}, {10, 10, 5}, kLabelLvBlood);
    // Two slices of wall beyond one without, of what was no section of this ventricle.
    fill(labels, p, {4, 4, 7}, {12, 6, 8}, kLabelLvMyocardium);
  }
  // It reaches the ventricle in one phase.
  fill(labels, 1, {4, 4, 6}, {12, 4, 6}, kLabelLvMyocardium);
  ImageCycle<std::uint8_t> alone = labels;
  keep_one_body({kLabelLvBlood, kLabelLvMyocardium}, kLabelRestOfHeart, labels);
  EXPECT_EQ(count_of(labels, 0, kLabelRestOfHeart), 2 * 9 * 3);
  EXPECT_EQ(count_of(labels, 0, kLabelLvMyocardium), 5 * 81 - 4 * 25);
  EXPECT_EQ(labels.phases[1], alone.phases[1]);
  EXPECT_EQ(count_of(labels, 0, kLabelLvBlood), 4 * 25);
}

TEST(Connected, APlaneCutsAVentricleInOnePieceThroughoutTheBeat) {
  ImageCycle<std::uint8_t> labels = cycle_of(8);
  fill(labels, 0, {2, 2, 3}, {7, 7, 3}, kLabelLvBlood);
  fill(labels, 1, {3, 3, 3}, {5, 5, 3}, kLabelLvBlood);
  // In the second phase alone the larger one.
  for (std::size_t p = 0; p < 2; ++p) fill(labels, p, {12, 12, 3}, {15, 15, 3}, kLabelLvBlood);
  keep_largest_of_each_slice({kLabelLvBlood}, kLabelBackground, labels);
  EXPECT_EQ(count_of(labels, 0, kLabelLvBlood), 6 * 6);
  EXPECT_EQ(count_of(labels, 1, kLabelLvBlood), 3 * 3);
}

}  // namespace
}  // namespace beatlas::segment
