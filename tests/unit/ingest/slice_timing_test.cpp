#include "pipeline/ingest/slice_timing.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace beatlas::ingest {
namespace {

std::vector<FrameStamp> evenly(int frames, double rr_ms, double start_ms, double printed_ms) {
  std::vector<FrameStamp> out(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) {
    FrameStamp& stamp = out[static_cast<std::size_t>((i * 13 + 3) % frames)];  // out of order
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

TEST(SliceTiming, TimesThatGoOnFromSliceToSliceCountFromTheFirstFrame) {
  const auto timing = time_slice(evenly(20, 800, 2370, 800));
  ASSERT_TRUE(timing);
  EXPECT_DOUBLE_EQ(timing->time_s.front(), 0);
  EXPECT_NEAR(timing->time_s.back(), 0.76, 1e-12);
  EXPECT_NE(timing->note.find("go on from one slice to the next"), std::string::npos)
      << timing->note;
  // A beat whose first frame comes late, but within it, stays where it is.
  EXPECT_NEAR(time_slice(evenly(20, 800, 790, 800))->time_s.front(), 0.79, 1e-12);
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

TEST(SliceTiming, OtherUnitsOfTriggerTimesAreRecognised) {
  const struct {
    double per_ms;
    const char* name;
  } units[] = {{1e-3, "seconds"}, {10, "tenths of a millisecond"}, {1000, "microseconds"}};
  for (const double printed_ms : {850.0, 0.0}) {
    const auto right = time_slice(evenly(25, 850, 40, printed_ms));
    for (const auto& unit : units) {
      auto stamps = evenly(25, 850, 40, printed_ms);
      for (FrameStamp& stamp : stamps) stamp.trigger_ms = *stamp.trigger_ms * unit.per_ms;
      const auto timing = time_slice(stamps);
      ASSERT_TRUE(timing);
      EXPECT_TRUE(timing->by_trigger) << unit.name;
      EXPECT_NE(timing->note.find(unit.name), std::string::npos) << timing->note;
      EXPECT_EQ(timing->order, right->order);
      EXPECT_NEAR(timing->rr_s, 0.85, 1e-9);
      EXPECT_NEAR(timing->time_s.back(), right->time_s.back(), 1e-9);
    }
  }
}

TEST(SliceTiming, ProspectiveGatingIsNotTakenForAnotherUnit) {
  for (const double reach : {0.4, 0.6, 0.85}) {
    const auto timing = time_slice(evenly(20, 900 * reach, 10, 900));
    EXPECT_EQ(timing->rr_s, 0.9);
    EXPECT_TRUE(timing->note.empty()) << timing->note;
  }
}

TEST(SliceTiming, OfSeveralBeatsTheFirstIsTaken) {
  // Times run on over two and over three and a half beats.
  for (const double beats : {2.0, 3.5}) {
    const int frames = static_cast<int>(20 * beats);
    const auto timing = time_slice(evenly(frames, 900 * beats, 5, 900));
    ASSERT_TRUE(timing);
    EXPECT_EQ(timing->order.size(), 20U);
    EXPECT_NEAR(timing->rr_s, 0.9, 1e-9);
    EXPECT_NE(timing->note.find("several beats"), std::string::npos) << timing->note;
  }
}

TEST(SliceTiming, ACycleRecordedTwiceIsTakenOnce) {
  for (const double later_ms : {0.0, 7.0}) {
    std::vector<FrameStamp> stamps;
    for (int i = 0; i < 40; ++i) {
      stamps.push_back({.trigger_ms = i % 20 * 45.0 + (i < 20 ? 0 : later_ms),
                        .rr_ms = 900.0,
                        .instance = i + 1.0});
    }
    const auto timing = time_slice(stamps);
    ASSERT_TRUE(timing);
    EXPECT_EQ(timing->order.size(), 20U);
    for (const int index : timing->order) EXPECT_LT(index, 20) << "of the first recording";
    EXPECT_NE(timing->note.find("twice"), std::string::npos) << timing->note;
  }
  // One cycle whose numbering starts in its middle is one.
  std::vector<FrameStamp> turned;
  for (int i = 0; i < 20; ++i) {
    turned.push_back({.trigger_ms = (i + 8) % 20 * 45.0, .rr_ms = 900.0, .instance = i + 1.0});
  }
  EXPECT_EQ(time_slice(turned)->order.size(), 20U);
}

TEST(SliceTiming, TimesThatStepByBeatsArePerfusion) {
  for (const double step : {900.0, 1800.0, 2700.0}) {
    const auto timing = time_slice(evenly(40, step * 40, 120, 900));
    ASSERT_TRUE(timing);
    EXPECT_TRUE(timing->many_beats);
    EXPECT_FALSE(timing->by_trigger);
  }
  EXPECT_FALSE(time_slice(evenly(40, 900, 0, 900))->many_beats);
}

std::vector<FrameStamp> untimed(int frames) {
  std::vector<FrameStamp> out(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) {
    out[static_cast<std::size_t>(i)].instance = frames - i;  // against the order of the beat
    out[static_cast<std::size_t>(i)].rr_ms = 900;
  }
  return out;
}

TEST(SliceTiming, OrderIsTakenFromTheMostTrustedField) {
  auto stamps = untimed(20);
  const auto first = [&] { return time_slice(stamps)->order.front(); };
  EXPECT_EQ(first(), 19) << "InstanceNumber";
  for (std::size_t i = 0; i < 20; ++i) stamps[i].content_s = 100 + 0.04 * static_cast<double>(i);
  EXPECT_EQ(time_slice(stamps)->source, "ContentTime");
  EXPECT_EQ(first(), 0);
  for (std::size_t i = 0; i < 20; ++i) {
    stamps[i].acquisition_s = 100 + 0.04 * static_cast<double>(19 - i);
  }
  EXPECT_EQ(time_slice(stamps)->source, "AcquisitionTime");
  EXPECT_EQ(first(), 19);
  for (std::size_t i = 0; i < 20; ++i)
    stamps[i].temporal_position = static_cast<double>((i + 2) % 20);
  EXPECT_EQ(first(), 18);
  for (std::size_t i = 0; i < 20; ++i)
    stamps[i].elapsed_ms = static_cast<double>((i + 3) % 20) * 45;
  EXPECT_EQ(first(), 17);
  EXPECT_TRUE(time_slice(stamps)->timed);
  for (std::size_t i = 0; i < 20; ++i)
    stamps[i].trigger_ms = static_cast<double>((i + 4) % 20) * 45;
  EXPECT_EQ(first(), 16);
}

TEST(SliceTiming, AClockThatContradictsTheNumbersIsNotBelieved) {
  // Images that were written in parallel, and a pair of frames that was swapped.
  for (const bool shuffled : {true, false}) {
    for (const auto clock : {&FrameStamp::content_s, &FrameStamp::acquisition_s}) {
      auto stamps = untimed(20);
      for (std::size_t i = 0; i < 20; ++i) {
        stamps[i].*clock = 100 + 0.04 * static_cast<double>(shuffled ? (7 * i) % 20 : i ^ 1U);
      }
      const auto timing = time_slice(stamps);
      EXPECT_EQ(timing->source, "InstanceNumber");
      EXPECT_EQ(timing->order.front(), 19);
      EXPECT_NE(timing->note.find("Time, which jumps from number to number"), std::string::npos)
          << timing->note;
      for (FrameStamp& stamp : stamps) stamp.instance.reset();
      EXPECT_NE(time_slice(stamps)->source, "InstanceNumber") << "no number, no contradiction";
    }
  }
}

TEST(SliceTiming, ClockTimesThatJumpOrderNothing) {
  auto stamps = untimed(20);
  for (std::size_t i = 0; i < 20; ++i) {
    stamps[i].acquisition_s = 100 + (i < 10 ? 0.04 : 0.3) * static_cast<double>(i);
  }
  EXPECT_EQ(time_slice(stamps)->source, "InstanceNumber");
}

TEST(SliceTiming, FrameTimePlacesFramesInTheBeat) {
  auto stamps = untimed(20);
  for (FrameStamp& stamp : stamps) stamp.frame_time_ms = 35;  // 700 of 900 ms
  const auto timing = time_slice(stamps);
  EXPECT_TRUE(timing->timed);
  EXPECT_NEAR(phases_of(*timing, 0)[19], 19 * 35 / 900.0, 1e-9);
  for (FrameStamp& stamp : stamps) stamp.frame_time_ms = 90;  // two beats
  EXPECT_EQ(time_slice(stamps)->order.size(), 10U);
  for (FrameStamp& stamp : stamps) stamp.frame_time_ms = 3;  // a TR, no frame's
  EXPECT_FALSE(time_slice(stamps)->timed);
  for (FrameStamp& stamp : stamps) {
    stamp.frame_time_ms = 40;
    stamp.rr_ms.reset();
  }
  EXPECT_NEAR(time_slice(stamps)->rr_s, 0.8, 1e-9);
}

TEST(SliceTiming, GivenTimesKeepTheOrder) {
  const auto timing = with_times(*time_slice(untimed(3)), {0.1, 0.2, 0.5}, 0);
  EXPECT_EQ(timing.order, (std::vector<int>{2, 1, 0}));
  EXPECT_EQ(timing.time_s, (std::vector<double>{0.1, 0.2, 0.5}));
  EXPECT_EQ(timing.rr_s, 0.9);
  EXPECT_EQ(with_times(timing, {0.1, 0.2, 0.5}, 2.0).rr_s, 2.0);
  EXPECT_NEAR(with_times(timing, {0, 0.6, 1.2}, 0).rr_s, 1.8, 1e-12) << "beyond what is recorded";
}

TEST(SliceTiming, UnseenShareIsTheGapLessOneStep) {
  EXPECT_NEAR(unseen_share({0, 0.1, 0.2, 0.3, 0.4}), 0.5, 1e-12);
  EXPECT_EQ(unseen_share({0, 0.2, 0.4, 0.6, 0.8}), 0);
  EXPECT_NEAR(unseen_share({0.8, 0.9, 0, 0.1}), 0.6, 1e-12);
}

TEST(SliceTiming, LargestGapGoesAroundTheCycle) {
  EXPECT_NEAR(largest_gap({0.1, 0.3, 0.5}), 0.6, 1e-12);
  EXPECT_NEAR(largest_gap({0.9, 0.0, 0.45}), 0.45, 1e-12);
  EXPECT_EQ(largest_gap({0.25}), 1);
}

TEST(SliceTiming, OfSeveralBeatsOnTheClockTheFirstIsTaken) {
  std::vector<FrameStamp> stamps(96);
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    stamps[i].acquisition_s = 43200 + 0.05 * static_cast<double>(i);
    stamps[i].rr_ms = 800;
  }
  const auto timing = time_slice(stamps);
  ASSERT_TRUE(timing);
  EXPECT_EQ(timing->order.size(), 16U);
  EXPECT_EQ(timing->source, "AcquisitionTime");
  EXPECT_NEAR(phases_of(*timing, 0)[8], 0.5, 1e-6);
  for (FrameStamp& stamp : stamps) stamp.rr_ms.reset();
  EXPECT_TRUE(time_slice(stamps)->beat_unknown);
  EXPECT_EQ(time_slice(stamps, 0.8)->order.size(), 16U);
}

TEST(SliceTiming, TimesOfSeveralBeatsAreNotAnotherUnit) {
  std::vector<FrameStamp> stamps(96);
  for (std::size_t i = 0; i < stamps.size(); ++i)
    stamps[i].trigger_ms = 50.0 * static_cast<double>(i);
  const auto timing = time_slice(stamps);
  ASSERT_TRUE(timing);
  EXPECT_TRUE(timing->beat_unknown);
  EXPECT_EQ(timing->note.find("taken as"), std::string::npos) << timing->note;
}

}  // namespace
}  // namespace beatlas::ingest
