#include "pipeline/motion/slice_timing.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/motion/acquisition_faults.h"
#include "runtime/base/error.h"

namespace beatlas::motion {
namespace {

constexpr int kPhases = 16;
constexpr int kSlices = 8;
constexpr int kSide = 48;

/// Share of the beat that a ventricle is emptied by, fast at first and filled in two steps.
double emptied(double beat) {
  beat -= std::floor(beat);
  return beat < 0.35 ? std::sin(1.5 * beat / 0.35) : std::exp(-(beat - 0.35) / 0.12);
}

/// A disc in noise, another one in each slice, whose radius beats: that of slice k by lags[k]
/// phases late.
Cine beating(const std::vector<int>& lags, double noise = 2) {
  Cine out;
  out.rr_interval_s = 0.8;
  out.images.grid.size = {kSide, kSide, kSlices};
  out.images.grid.mm_from_index.linear() = Vec3(2.2, 2.2, 8).asDiagonal();
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, noise);
  for (int p = 0; p < kPhases; ++p) {
    out.frame_times_s.push_back(0.8 * p / kPhases);
    std::vector<float>& image = out.images.phases.emplace_back();
    for (int k = 0; k < kSlices; ++k) {
      const double beat = static_cast<double>(p - lags[static_cast<std::size_t>(k)]) / kPhases;
      const double radius = (12 + 0.5 * k) * (1 - 0.3 * emptied(beat));
      for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
          const double inside = radius - std::hypot(i - 22.0 - 0.4 * k, j - 25.0);
          image.push_back(
              static_cast<float>(100 + 100 * std::clamp(inside + 0.5, 0.0, 1.0) + normal(random)));
        }
      }
    }
  }
  return out;
}

TEST(SliceTiming, SlicesInStepStay) {
  EXPECT_EQ(slice_lags(beating(std::vector<int>(kSlices, 0))), std::vector<int>(kSlices, 0));
  Exam exam;
  exam.stack = beating(std::vector<int>(kSlices, 0));
  const Exam same = with_slices_in_step(exam);
  EXPECT_TRUE(same.decisions.empty() && same.slice_lags.empty());
  EXPECT_EQ(same.stack.images.phases, exam.stack.images.phases);
}

TEST(SliceTiming, FindsTheSlicesThatAreOut) {
  const std::vector<int> lags{0, 0, 3, 0, -2, 0, 0, 4};
  EXPECT_EQ(slice_lags(beating(lags)), lags);
}

TEST(SliceTiming, ASliceMayBeOutByHalfABeat) {
  const std::vector<int> lags{0, 0, 6, 0, 0, kPhases / 2, 0, 0};
  const std::vector<int> found = slice_lags(beating(lags));
  for (std::size_t k = 0; k < lags.size(); ++k) {
    EXPECT_EQ((found[k] - lags[k]) % kPhases, 0) << "slice " << k << ": " << found[k];
  }
}

TEST(SliceTiming, EverySliceMayBeOut) {
  // The middle one of them is the stack's beat.
  const std::vector<int> lags{-3, 2, 0, 3, -2, 0, -3, 2};
  EXPECT_EQ(slice_lags(beating(lags)), lags);
}

TEST(SliceTiming, OnePhaseOfManyIsTheHeartsOwn) {
  EXPECT_EQ(slice_lags(beating({0, 1, 0, 0, -1, 0, 0, 1})), std::vector<int>(kSlices, 0));
}

TEST(SliceTiming, NoiseHasNoBeat) {
  Cine noise = beating(std::vector<int>(kSlices, 0));
  std::mt19937 random(3);
  std::normal_distribution<float> normal(100, 10);
  for (std::vector<float>& phase : noise.images.phases) {
    for (float& value : phase) value = normal(random);
  }
  EXPECT_EQ(slice_lags(noise), std::vector<int>(kSlices, 0));
}

TEST(SliceTiming, FramesOfAPartOfTheBeatCannotBeTurnedRound) {
  const std::vector<int> lags{0, 0, 3, 0, -2, 0, 0, 4};
  Cine part = beating(lags);
  part.rr_interval_s = 1.1;
  EXPECT_EQ(slice_lags(part), std::vector<int>(kSlices, 0));
}

TEST(SliceTiming, SlicesThatShowAPartOfTheHeartAreLeft) {
  Cine part = beating({0, 0, 3, 0, -2, 0, 0, 4});
  part.images.grid.mm_from_index.linear() = Vec3(2, 2, 8).asDiagonal();
  EXPECT_EQ(slice_lags(part), std::vector<int>(kSlices, 0));
}

TEST(SliceTiming, UndoesToTheVoxelAndTells) {
  std::vector<int> lags{0, 0, 3, 0, -2, 0, 0, 4};
  const Cine in_step = beating(std::vector<int>(kSlices, 0), 0);
  Exam exam;
  exam.stack = beating(lags, 0);
  ASSERT_NE(exam.stack.images.phases, in_step.images.phases);
  const Exam mended = without_acquisition_faults(exam, {});
  EXPECT_EQ(mended.stack.images.phases, in_step.images.phases);
  EXPECT_EQ(mended.slice_lags, lags);
  ASSERT_EQ(mended.decisions.size(), 1U);
  EXPECT_EQ(mended.decisions.front(),
            "Warning: 3 of 8 slices show the beat out of step with the others (most slice 7, whose "
            "frames come 4 of 16 phases too late); their frames were moved round the beat; "
            "/import/align_slices off in a recipe leaves them.");

  AlignOptions off;
  off.slices = AlignOptions::Slices::Off;
  EXPECT_EQ(without_acquisition_faults(exam, off).stack.images.phases, exam.stack.images.phases);
}

TEST(SliceTiming, RefusesLagsOfOtherSlices) {
  EXPECT_THROW((void)without_lags(beating(std::vector<int>(kSlices, 0)).images, {0, 1}), Error);
}

}  // namespace
}  // namespace beatlas::motion
