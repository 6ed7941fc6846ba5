#include "pipeline/ingest/frame_timing.h"

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

using formats::FrameAxis;
using formats::ImageFileHeader;

bool told(const FrameTiming& timing, const std::string& words) {
  for (const std::string& decision : timing.decisions) {
    if (decision.find(words) != std::string::npos) return true;
  }
  return false;
}

std::string refusal(const ImageFileHeader& header, int frames, const IngestOptions& options = {}) {
  try {
    (void)time_frames(header, frames, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "was timed";
}

TEST(FrameTiming, IntervalMakesTheRrInterval) {
  const auto timing = time_frames(
      {.frame_axis = FrameAxis::Time, .frame_interval_s = 0.04, .unit_known = true}, 20, {});
  EXPECT_NEAR(timing.rr_s, 0.8, 1e-12);
  EXPECT_TRUE(timing.even);
  EXPECT_EQ(timing.phases[5], 0.25);
  EXPECT_NEAR(timing.time_s[5], 0.2, 1e-12);
  ASSERT_EQ(timing.decisions.size(), 1U);
  EXPECT_TRUE(told(timing,
                   "by the frame interval of the file; the R-R interval is 800 ms, the "
                   "times of the frames were taken as even"));
}

TEST(FrameTiming, IntervalOfOneSecondIsWhatToolsWriteWithoutKnowing) {
  for (const bool unit_known : {false, true}) {
    const ImageFileHeader header{.frame_axis = unit_known ? FrameAxis::Time : FrameAxis::Untold,
                                 .frame_interval_s = 1,
                                 .unit_known = unit_known};
    for (const int frames : {2, 3, 20}) {
      EXPECT_NE(refusal(header, frames).find("--rr SECONDS"), std::string::npos) << frames;
      const auto timing = time_frames(header, frames, {.rr_interval_s = 0.9});
      EXPECT_FALSE(told(timing, "Warning")) << "an interval that tells nothing contradicts nothing";
      EXPECT_TRUE(told(timing, "by the given R-R interval; the R-R interval is 900 ms"));
    }
  }
  EXPECT_NEAR(
      time_frames({.frame_axis = FrameAxis::Time, .frame_interval_s = 0.99, .unit_known = true}, 2,
                  {})
          .rr_s,
      1.98, 1e-12);
}

TEST(FrameTiming, NumbersWithoutAUnitAreTriedAsSecondsThenMilliseconds) {
  auto timing = time_frames({.frame_axis = FrameAxis::Untold, .frame_interval_s = 0.04}, 20, {});
  EXPECT_NEAR(timing.rr_s, 0.8, 1e-12);
  EXPECT_TRUE(told(timing, "no unit of time"));
  timing = time_frames({.frame_axis = FrameAxis::Untold, .frame_interval_s = 40}, 20, {});
  EXPECT_NEAR(timing.rr_s, 0.8, 1e-12);
  EXPECT_TRUE(told(timing, "milliseconds"));
}

TEST(FrameTiming, WithoutTimeItMustBeGiven) {
  for (const ImageFileHeader& header :
       {ImageFileHeader{.frame_axis = FrameAxis::Untold},
        ImageFileHeader{.frame_axis = FrameAxis::Untold, .frame_interval_s = 1},
        ImageFileHeader{
            .frame_axis = FrameAxis::Time, .frame_interval_s = 5, .unit_known = true}}) {
    EXPECT_NE(refusal(header, 2).find("--rr SECONDS"), std::string::npos) << refusal(header, 2);
    const auto timing = time_frames(header, 2, {.rr_interval_s = 0.9});
    EXPECT_EQ(timing.rr_s, 0.9);
    EXPECT_TRUE(timing.even);
    EXPECT_TRUE(told(timing, "was given"));
  }
}

TEST(FrameTiming, AxisThatIsNoTimeIsRefusedWhateverIsGiven) {
  const ImageFileHeader header{.frame_axis = FrameAxis::Other, .frame_axis_is = "a colour"};
  EXPECT_NE(refusal(header, 10, {.rr_interval_s = 0.9}).find("is a colour, not the time"),
            std::string::npos);
}

TEST(FrameTiming, TimesThatTheFileNamesArePhasesOfTheRrInterval) {
  const ImageFileHeader header{.frame_axis = FrameAxis::Time,
                               .frame_times_s = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75},
                               .unit_known = true};
  auto timing = time_frames(header, 8, {.rr_interval_s = 0.8});
  EXPECT_FALSE(timing.even);
  EXPECT_EQ(timing.phases[0], 0);
  EXPECT_NEAR(timing.phases[7], 0.65 / 0.8, 1e-12);
  EXPECT_EQ(timing.time_s[0], 0.1);
  EXPECT_TRUE(told(timing, "by the frame times of the file; the R-R interval is 800 ms."));
  EXPECT_NEAR(time_frames(header, 8, {}).rr_s, 0.65 * 8 / 7, 1e-12);
  // An R-R interval that cannot hold them.
  timing = time_frames(header, 8, {.rr_interval_s = 0.6});
  EXPECT_TRUE(timing.even);
  EXPECT_TRUE(told(timing, "do not fit"));
}

TEST(FrameTiming, ImagesThatStopBeforeTheNextBeatAreTold) {
  ImageFileHeader header{.frame_axis = FrameAxis::Time, .unit_known = true};
  for (int p = 0; p < 12; ++p) header.frame_times_s.push_back(0.04 * p);
  const auto timing = time_frames(header, 12, {.rr_interval_s = 0.8});
  EXPECT_TRUE(told(timing, "leave out 45 % of the R-R interval"));
  EXPECT_FALSE(told(time_frames(header, 12, {}), "leave out"));
}

TEST(FrameTiming, TimesThatDoNotRiseAreLeft) {
  const ImageFileHeader header{
      .frame_axis = FrameAxis::Time, .frame_times_s = {0, 0.1, 0.1, 0.3}, .unit_known = true};
  EXPECT_NE(refusal(header, 4).find("--rr"), std::string::npos);
  EXPECT_TRUE(told(time_frames(header, 4, {.rr_interval_s = 0.8}), "do not rise"));
}

TEST(FrameTiming, GivenTimesReplaceTheFiles) {
  const ImageFileHeader header{
      .frame_axis = FrameAxis::Time, .frame_interval_s = 0.04, .unit_known = true};
  const auto timing =
      time_frames(header, 3, {.rr_interval_s = 0.9, .frame_times_s = {0, 0.2, 0.3}});
  EXPECT_EQ(timing.rr_s, 0.9);
  EXPECT_NEAR(timing.phases[2], 1.0 / 3, 1e-12);
  EXPECT_TRUE(told(timing, "The R-R interval was given"));
  EXPECT_TRUE(told(timing, "The frame times were given"));
  EXPECT_TRUE(told(timing, "by the given frame times; the R-R interval is 900 ms."));
  EXPECT_NE(refusal(header, 4, {.frame_times_s = {0, 0.2, 0.3}}).find("4 phases, but 3"),
            std::string::npos);
  EXPECT_NE(refusal(header, 3, {.frame_times_s = {0, 0.3, 0.2}}).find("do not rise"),
            std::string::npos);
  EXPECT_NE(refusal(header, 3, {.frame_times_s = {0, 300, 600}}).find("in seconds"),
            std::string::npos);
}

}  // namespace
}  // namespace beatlas::ingest
