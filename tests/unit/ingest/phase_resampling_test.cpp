#include "pipeline/ingest/phase_resampling.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

namespace beatlas::ingest {
namespace {

std::vector<double> even(int count, double start) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i)
    out.push_back(std::fmod(start + static_cast<double>(i) / count, 1));
  return out;
}

/// Of frames of one voxel.
float blended(const std::vector<std::vector<float>>& frames, const PhaseTaps& taps) {
  float out = 0;
  blend_to(frames, taps, &out);
  return out;
}

double worst(const std::vector<double>& phases, int count,
             const std::function<double(double)>& signal) {
  std::vector<std::vector<float>> frames;
  for (const double phase : phases) frames.push_back({static_cast<float>(signal(phase))});
  const auto taps = resample_phases(phases, count);
  double out = 0;
  for (int p = 0; p < count; ++p) {
    const double value = blended(frames, taps[static_cast<std::size_t>(p)]);
    out = std::max(out, std::abs(value - signal(static_cast<double>(p) / count)));
  }
  return out;
}

double beat(double phase) {
  return std::cos(2 * std::numbers::pi * phase) + 0.4 * std::sin(4 * std::numbers::pi * phase);
}

TEST(PhaseResampling, FramesOnCommonPhasesAreCopied) {
  for (const auto& taps : resample_phases(even(25, 0), 25)) EXPECT_EQ(taps.count, 1);
  EXPECT_EQ(worst(even(25, 0), 25, [](double p) { return std::floor(25 * p + 0.5); }), 0);
}

TEST(PhaseResampling, ConvergesWithTheThirdPowerOfTheStep) {
  const double coarse = worst(even(20, 0.021), 20, beat);
  const double fine = worst(even(40, 0.0105), 40, beat);
  EXPECT_LT(coarse, 0.01);
  EXPECT_GT(coarse / fine, 6.5);  // 8 for third order, 4 for linear
}

TEST(PhaseResampling, WeightsSumToOneOnUnevenFrames) {
  const std::vector<double> phases{0.97, 0.03, 0.1, 0.2, 0.24, 0.4, 0.55, 0.6, 0.7, 0.9};
  for (const auto& taps : resample_phases(phases, 17)) {
    EXPECT_NEAR(std::accumulate(taps.weight.begin(), taps.weight.begin() + taps.count, 0.0), 1,
                1e-12);
  }
  // A line is reproduced away from the seam of the cycle.
  std::vector<std::vector<float>> frames;
  for (const double phase : phases) frames.push_back({static_cast<float>(phase)});
  const auto taps = resample_phases(phases, 10);
  for (std::size_t p = 3; p < 7; ++p) {
    EXPECT_NEAR(blended(frames, taps[p]), static_cast<double>(p) / 10, 0.02);
  }
}

TEST(PhaseResampling, FewFramesAreAssignedInOrderNotBlended) {
  const auto taps = resample_phases({0.36, 0.961}, 2);
  EXPECT_EQ(taps[0].count, 1);
  EXPECT_EQ(taps[0].frame[0], 1) << "end diastole belongs to phase 0";
  EXPECT_EQ(taps[1].frame[0], 0);
  const auto more = resample_phases({0.1, 0.5, 0.8}, 6);
  for (const auto& tap : more) EXPECT_EQ(tap.count, 1);
  EXPECT_EQ(more[0].frame[0], 0);
  EXPECT_EQ(more[3].frame[0], 1);
}

}  // namespace
}  // namespace beatlas::ingest
