#include "pipeline/ingest/slice_timing.h"

#include <cmath>

#include <gtest/gtest.h>

namespace beatlas::ingest {
namespace {

std::vector<FrameStamp> evenly(int frames, double rr_ms, double start_ms, double printed_ms) {
  std::vector<FrameStamp> out(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) {
    FrameStamp& stamp = out[static_cast<std::size_t>((i * 7 + 3) % frames)];  // out of order
    stamp.trigger_ms = start_ms + i * rr_ms / frames;
    stamp.instance = i;
    if (printed_ms > 0) stamp.rr_ms = printed_ms;
  }
  return out;
}

TEST(SliceTiming, TriggerTimesOrderTheFrames) {
  const auto timing = time_slice(evenly(25, 850, 40, 850));
  ASSERT_TRUE(timing);
  EXPECT_TRUE(timing->by_trigger);
  EXPECT_TRUE(std::is_sorted(timing->time_s.begin(), timing->time_s.end()));
  EXPECT_NEAR(timing->rr_s, 0.85, 1e-12);
  const auto phases = phases_of(*timing, 0);
  for (int i = 0; i < 25; ++i) {
    EXPECT_NEAR(phases[static_cast<std::size_t>(i)], std::fmod(40.0 / 850 + i / 25.0, 1.0), 1e-9);
  }
}

TEST(SliceTiming, RoundedIntervalAndTimesGiveExactPhases) {
  const auto exact = time_slice(evenly(15, 933.333, 0, 933));
  ASSERT_TRUE(exact);
  EXPECT_NEAR(exact->rr_s, 0.933333, 1e-6);
  auto stamps = evenly(20, 967, 0, 967);
  for (FrameStamp& stamp : stamps) stamp.trigger_ms = std::round(*stamp.trigger_ms);
  const auto phases = phases_of(*time_slice(stamps), 0);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_NEAR(phases[i], static_cast<double>(i) / 20, 1e-12);
  }
}

TEST(SliceTiming, UnevenTimesStayUneven) {
  std::vector<FrameStamp> stamps(3);
  const double times[] = {10, 200, 600};
  for (std::size_t i = 0; i < 3; ++i) {
    stamps[i].trigger_ms = times[i];
    stamps[i].rr_ms = 1000;
  }
  EXPECT_EQ(phases_of(*time_slice(stamps), 0), (std::vector<double>{0.01, 0.2, 0.6}));
}

TEST(SliceTiming, TimesBeyondThePrintedIntervalCorrectIt) {
  const auto timing = time_slice(evenly(20, 1000, 0, 600));
  ASSERT_TRUE(timing);
  EXPECT_NEAR(timing->rr_s, 1.0, 1e-9);
  EXPECT_NE(timing->note.find("beyond"), std::string::npos);
}

TEST(SliceTiming, ImagesOfOneTriggerTimeCountOnce) {
  auto stamps = evenly(10, 900, 0, 900);
  const auto twice = evenly(10, 900, 0, 900);
  stamps.insert(stamps.end(), twice.begin(), twice.end());
  const auto timing = time_slice(stamps);
  ASSERT_TRUE(timing);
  EXPECT_EQ(timing->order.size(), 10U);
  for (const int index : timing->order) EXPECT_LT(index, 10) << "the first of each pair";
}

TEST(SliceTiming, ImagesWithoutAnyOrderAreNoCine) {
  EXPECT_FALSE(time_slice(std::vector<FrameStamp>(5)));
  EXPECT_FALSE(time_slice(evenly(1, 900, 0, 900)));
}

TEST(SliceTiming, LargestGapGoesAroundTheCycle) {
  EXPECT_NEAR(largest_gap({0.1, 0.3, 0.5}), 0.6, 1e-12);
  EXPECT_NEAR(largest_gap({0.9, 0.0, 0.45}), 0.45, 1e-12);
  EXPECT_EQ(largest_gap({0.25}), 1);
}

}  // namespace
}  // namespace beatlas::ingest
