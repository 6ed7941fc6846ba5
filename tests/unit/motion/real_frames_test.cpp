/// Gains of frames and lags of slices in real exams, which are no part of the project: skipped
/// where they are absent.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/ingest/ingest.h"
#include "pipeline/motion/frame_gains.h"
#include "pipeline/motion/slice_timing.h"
#include "tests/real_exams.h"

namespace beatlas::motion {
namespace {

constexpr double kCutMm = 120;  // about as wide as a heart with 12 mm beside it

class RealFrames : public testing::TestWithParam<const char*> {};

Cine stack_of(const char* name) {
  StageContext context;
  return ingest::read_exam({test::real_exam(name)}, {}, context).stack;
}

/// A square about the middle of what changes through the beat.
ImageCycle<float> cut_about_motion(const ImageCycle<float>& images) {
  const Grid& grid = images.grid;
  const auto phases = static_cast<double>(images.phases.size());
  Vec2 sum = Vec2::Zero();
  double all = 0;
  for (std::size_t v = 0; v < grid.count(); ++v) {
    double mean = 0;
    double square = 0;
    for (const std::vector<float>& phase : images.phases) {
      mean += static_cast<double>(phase[v]) / phases;
      square += static_cast<double>(phase[v]) * static_cast<double>(phase[v]) / phases;
    }
    const double variance = std::max(0.0, square - mean * mean);
    const auto row = static_cast<std::size_t>(grid.size[0]);
    const std::size_t in_slice = v % grid.slice_count();
    sum +=
        variance * Vec2(static_cast<double>(in_slice % row), static_cast<double>(in_slice / row));
    all += variance;
  }
  Index3 first{0, 0, 0};
  Index3 size = grid.size;
  for (int axis = 0; axis < 2; ++axis) {
    size[axis] =
        std::min(grid.size[axis], static_cast<int>(std::ceil(kCutMm / grid.spacing_mm()[axis])));
    const int middle = static_cast<int>(std::lround(sum[axis] / all));
    first[axis] = std::clamp(middle - size[axis] / 2, 0, grid.size[axis] - size[axis]);
  }
  ImageCycle<float> out;
  out.grid = grid;
  out.grid.size = size;
  for (const std::vector<float>& phase : images.phases) {
    std::vector<float>& cut = out.phases.emplace_back();
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        const auto from =
            phase.begin() + static_cast<std::ptrdiff_t>(grid.offset(first[0], first[1] + j, k));
        cut.insert(cut.end(), from, from + size[0]);
      }
    }
  }
  return out;
}

double most_off(const ImageCycle<float>& images) {
  double most = 0;
  for (const auto& of_slice : frame_gains(images)) {
    for (const double gain : of_slice) most = std::max(most, std::abs(gain - 1));
  }
  return most;
}

TEST_P(RealFrames, AreAlikeAndOfABrightOneTheGainIsFound) {
  BEATLAS_NEEDS_REAL_EXAM(GetParam());
  ImageCycle<float> images = stack_of(GetParam()).images;
  const double whole = most_off(images);
  const double cut = most_off(cut_about_motion(images));
  std::printf("%s: %.3f, cut %.3f\n", GetParam(), whole, cut);
  EXPECT_LT(whole, 0.02);
  EXPECT_LT(cut, 0.1);
  constexpr double kGain = 1.3;
  for (float& value : images.phases[0]) value *= static_cast<float>(kGain);
  for (const auto& of_slice : frame_gains(images)) {
    const double other = of_slice[of_slice.size() / 2];
    EXPECT_NEAR(of_slice[0] / other, kGain, 0.03);
  }
}

TEST_P(RealFrames, ShowTheBeatInStepAndASliceAmidThemThatIsLateIsFound) {
  BEATLAS_NEEDS_REAL_EXAM(GetParam());
  Cine stack = stack_of(GetParam());
  std::vector<int> late(static_cast<std::size_t>(stack.grid().size[2]), 0);
  EXPECT_EQ(slice_lags(stack), late);
  if (stack.phase_count() < 8) return;
  for (const double share : {0.2, -0.2}) {
    const int lag = static_cast<int>(std::lround(share * stack.phase_count()));
    late[late.size() / 2] = -lag;
    stack.images = without_lags(std::move(stack.images), late);
    late[late.size() / 2] = lag;
    const std::vector<int> found = slice_lags(stack);
    std::printf("%s: %d, found %d\n", GetParam(), lag, found[late.size() / 2]);
    EXPECT_NEAR(found[late.size() / 2], lag, 1);
    EXPECT_EQ(std::count(found.begin(), found.end(), 0), stack.grid().size[2] - 1);
    stack.images = without_lags(std::move(stack.images), late);
  }
}

INSTANTIATE_TEST_SUITE_P(OfExams, RealFrames,
                         testing::Values("sunnybrook/SCD0000101", "sunnybrook/SCD0000401",
                                         "two-phase-ge", "cine-exam"));

}  // namespace
}  // namespace beatlas::motion
