#include "pipeline/motion/phase_motion.h"

#include <cmath>
#include <iostream>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"

namespace beatlas::motion::phase_motion_tests {
namespace {

constexpr int kPhases = 8;
constexpr Index3 kSize{96, 80, 3};

/// Where the pattern lies in a phase: it goes round a circle, each slice at its own radius.
Vec2 place(int phase, int k) {
  const double angle = 2 * std::numbers::pi * phase / kPhases;
  const double radius = 3.0 + k;
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// Blobs some 10 voxels wide, of 100 +- 80.
double pattern(double x, double y) {
  return 100 + 40 * std::sin(0.31 * x + 0.2 * y) + 40 * std::cos(0.27 * y - 0.16 * x + 1);
}

ImageCycle<float> moving_pattern() {
  ImageCycle<float> out;
  out.grid.size = kSize;
  for (int p = 0; p < kPhases; ++p) {
    std::vector<float>& image = out.phases.emplace_back(out.grid.count());
    for (int k = 0; k < kSize[2]; ++k) {
      const Vec2 at = place(p, k);
      for (int j = 0; j < kSize[1]; ++j) {
        for (int i = 0; i < kSize[0]; ++i) {
          image[out.grid.offset(i, j, k)] = static_cast<float>(pattern(i - at[0], j - at[1]));
        }
      }
    }
  }
  return out;
}

ImageCycle<float> uniform(const Index3& size, int phases) {
  ImageCycle<float> out;
  out.grid.size = size;
  out.phases.assign(static_cast<std::size_t>(phases), std::vector<float>(out.grid.count(), 70));
  return out;
}

TEST(PhaseMotion, OfAPatternThatGoesRoundIsItsWayFromPhaseToPhase) {
  const ImageCycle<float> images = moving_pattern();
  const PhaseMotion motion = phase_motion(images, 200);
  ASSERT_EQ(motion.to_next.size(), static_cast<std::size_t>(kPhases));
  constexpr int kRim = 12;  // what comes in at the rim was nowhere before
  for (int p = 0; p < kPhases; ++p) {
    for (int k = 0; k < kSize[2]; ++k) {
      double next = 0;
      double previous = 0;
      int count = 0;
      for (int j = kRim; j + kRim < kSize[1]; ++j) {
        for (int i = kRim; i + kRim < kSize[0]; ++i, ++count) {
          const std::size_t v = images.grid.offset(i, j, k);
          const auto off = [&](const PlaneStep& step, int to) {
            return (Vec2(step[0], step[1]) - (place(to, k) - place(p, k))).norm();
          };
          next += off(motion.to_next[static_cast<std::size_t>(p)][v], p + 1);
          previous += off(motion.to_previous[static_cast<std::size_t>(p)][v], p - 1);
        }
      }
      // Of 2.3 to 3.8 voxels. Whole steps alone are off by 0.38 of one, on average.
      EXPECT_LT(next / count, 0.9) << p << ' ' << k;
      EXPECT_LT(previous / count, 0.9) << p << ' ' << k;
    }
  }
}

TEST(PhaseMotion, EndsWithinTheSlice) {
  const ImageCycle<float> images = moving_pattern();
  const PhaseMotion motion = phase_motion(images, 200);
  for (const auto* steps : {&motion.to_next, &motion.to_previous}) {
    for (const auto& phase : *steps) {
      for (int j = 0; j < kSize[1]; ++j) {
        for (int i = 0; i < kSize[0]; ++i) {
          const PlaneStep& step = phase[images.grid.offset(i, j, 1)];
          ASSERT_TRUE(images.grid.contains(i + step[0], j + step[1], 1)) << i << ' ' << j;
        }
      }
    }
  }
}

TEST(PhaseMotion, OfWhatShowsNothingIsNone) {
  for (const Index3& size : {Index3{40, 40, 2}, Index3{1, 1, 1}, Index3{3, 70, 1}}) {
    const PhaseMotion motion = phase_motion(uniform(size, 2), 100);
    for (const auto& phase : motion.to_next) {
      for (const PlaneStep& step : phase) ASSERT_EQ(step, (PlaneStep{0, 0})) << size[0];
    }
  }
}

TEST(PhaseMotion, ToAPhaseThatShowsSomethingElseIsToldOfLittle) {
  ImageCycle<float> images = moving_pattern();
  constexpr int kOdd = 3;
  for (int j = 0; j < kSize[1]; ++j) {
    for (int i = 0; i < kSize[0]; ++i) {
      const double other = pattern(0.3 * i * j / kSize[0] + 40, 1.6 * j - 0.4 * i);
      images.phases[kOdd][images.grid.offset(i, j, 0)] = static_cast<float>(other);
    }
  }
  const PhaseMotion motion = phase_motion(images, 200);
  const auto moved_share = [&](int phase) {
    int moved = 0;
    for (std::size_t v = 0; v < images.grid.slice_count(); ++v) {
      moved += motion.to_next[static_cast<std::size_t>(phase)][v] != PlaneStep{0, 0} ? 1 : 0;
    }
    return static_cast<double>(moved) / static_cast<double>(images.grid.slice_count());
  };
  std::cout << "moved: " << moved_share(0) << " of a phase to the next, " << moved_share(kOdd - 1)
            << " and " << moved_share(kOdd) << " to and from one that is unlike it\n";
  EXPECT_GT(moved_share(0), 0.8);
  EXPECT_LT(moved_share(kOdd - 1), 0.5);
  EXPECT_LT(moved_share(kOdd), 0.5);
}

TEST(PhaseMotion, IsTheSameOnOneThreadAndTwo) {
  const ImageCycle<float> images = moving_pattern();
  set_thread_count(1);
  const PhaseMotion one = phase_motion(images, 200);
  set_thread_count(2);
  const PhaseMotion two = phase_motion(images, 200);
  set_thread_count(0);
  EXPECT_EQ(one.to_next, two.to_next);
  EXPECT_EQ(one.to_previous, two.to_previous);
}

}  // namespace
}  // namespace beatlas::motion::phase_motion_tests
