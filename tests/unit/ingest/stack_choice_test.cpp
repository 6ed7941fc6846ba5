#include "pipeline/ingest/stack_choice.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/ingest/made_images.h"

namespace beatlas::ingest::stack_choice_tests {
namespace {

using test::append;
using test::joined;
using test::made_stack;
using test::no_files;
using test::told;

Choice choose(const std::vector<DicomImage>& images, const IngestOptions& options = {}) {
  return choose_stack(images, options, no_files());
}

std::string refusal(const std::vector<DicomImage>& images, const IngestOptions& options = {}) {
  try {
    (void)choose(images, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return "was chosen";
}

/// A plane of another orientation.
test::MadeStack oblique(test::MadeStack made) {
  made.row = Vec3(std::sqrt(0.5), std::sqrt(0.5), 0);
  made.column = Vec3(0, 0, -1);
  return made;
}

test::MadeStack coronal(test::MadeStack made) {
  made.row = Vec3::UnitX();
  made.column = -Vec3::UnitZ();
  return made;
}

TEST(StackChoice, MostSlicesWinAndTheListSaysWhy) {
  auto images = made_stack({.slices = 4, .phases = 30});
  append(images, made_stack(coronal({.slices = 9, .first_series = 50, .gap_mm = 10})));
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.size(), 9U);
  EXPECT_TRUE(told(choice.decisions,
                   "Possible stacks: 1. 9 slices x 10 phases, 10.00 mm apart, coronal (series "
                   "50-58), chosen because it has most parallel slices; 2. 4 slices x 30 phases, "
                   "8.00 mm apart, axial (series 1-4)."))
      << joined(choice.decisions);
}

TEST(StackChoice, AnotherStackIsTakenIfAskedFor) {
  auto images = made_stack({.slices = 4, .phases = 30});
  append(images, made_stack(oblique({.slices = 9, .first_series = 50})));
  const Choice choice = choose(images, {.stack = 2});
  EXPECT_EQ(choice.stack.slices.size(), 4U);
  EXPECT_EQ(choice.phases, 30);
  EXPECT_TRUE(told(choice.decisions, "(series 1-4), chosen as asked")) << joined(choice.decisions);
  const std::string message = refusal(images, {.stack = 3});
  EXPECT_NE(message.find("there is no stack 3"), std::string::npos) << message;
  EXPECT_NE(message.find("2. 4 slices"), std::string::npos) << message;
}

TEST(StackChoice, OrientationsAreNamed) {
  const Vec3 x = Vec3::UnitX();
  const Vec3 y = Vec3::UnitY();
  const Vec3 z = Vec3::UnitZ();
  EXPECT_TRUE(told(choose(made_stack({.row = x, .column = y})).decisions, "axial"));
  EXPECT_TRUE(told(choose(made_stack({.row = x, .column = -z})).decisions, "coronal"));
  EXPECT_TRUE(told(choose(made_stack({.row = y, .column = -z})).decisions, "sagittal"));
}

TEST(StackChoice, FlowIsNeverPreferredOverACine) {
  // More slices, more phases, magnitude and velocity in one series or in two.
  for (const int velocity_series : {50, 51}) {
    auto images = made_stack({.slices = 4});
    test::MadeStack flow = oblique(
        {.slices = 8, .phases = 20, .first_series = 50, .series_per_slice = false, .echo_ms = 2.5});
    append(images, made_stack(flow));
    flow.first_series = velocity_series;
    flow.magnitude = false;
    append(images, made_stack(flow));
    const Choice choice = choose(images);
    EXPECT_EQ(choice.stack.slices.size(), 4U) << joined(choice.decisions);
    EXPECT_TRUE(told(choice.decisions, "oblique, flow (series 50)")) << joined(choice.decisions);
    EXPECT_TRUE(choice.views.empty());
    EXPECT_EQ(choose(images, {.stack = 2}).stack.slices.size(), 8U);
  }
}

TEST(StackChoice, PerfusionIsNeverPreferredOverACine) {
  auto images = made_stack({.slices = 3, .phases = 8});
  append(images,
         made_stack(oblique({.slices = 4, .phases = 60, .first_series = 50, .step_ms = 900})));
  // Constant trigger times, but the clock says one image a beat.
  auto clocked = made_stack({.slices = 5,
                             .phases = 40,
                             .first_series = 70,
                             .row = Vec3::UnitY(),
                             .column = Vec3::UnitZ()});
  for (DicomImage& image : clocked) {
    image.stamp.trigger_ms = 100;
    image.stamp.acquisition_s = 36000 + 0.9 * *image.stamp.instance;
  }
  append(images, clocked);
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.size(), 3U) << joined(choice.decisions);
  EXPECT_TRUE(told(choice.decisions, "one image a beat (series 50-53)"))
      << joined(choice.decisions);
  EXPECT_TRUE(told(choice.decisions, "one image a beat (series 70-74)"))
      << joined(choice.decisions);
}

TEST(StackChoice, SlicesOfOneContrastAreNotMixedWithAnother) {
  // A later series of tagged images at three of the places.
  auto images = made_stack({.slices = 9});
  append(images, made_stack({.slices = 3,
                             .first_series = 50,
                             .origin = {0, 0, 16},
                             .echo_ms = 3.8,
                             .sequence = "GR\nSP"}));
  const Choice choice = choose(images);
  ASSERT_EQ(choice.stack.slices.size(), 9U) << joined(choice.decisions);
  for (const ImageSet& set : choice.stack.slices) EXPECT_LT(set.series_number, 10);
  EXPECT_TRUE(told(choice.decisions, "because it has the contrast that most cines of the exam"))
      << joined(choice.decisions);
}

TEST(StackChoice, WithoutMagnitudeImagesItSaysSo) {
  EXPECT_NE(refusal(made_stack({.magnitude = false})).find("velocity) images only"),
            std::string::npos);
}

TEST(StackChoice, LargestAndSmallestStacksAreRead) {
  const Choice large =
      choose(made_stack({.slices = 300, .phases = 100, .gap_mm = 1, .pixels = 1024}));
  EXPECT_EQ(large.stack.grid.size, (Index3{1024, 1024, 300}));
  EXPECT_EQ(large.phases, 100);
  const Choice small = choose(made_stack({.slices = 3, .phases = 2}));
  EXPECT_EQ(small.stack.grid.size, (Index3{64, 64, 3}));
  EXPECT_EQ(small.phases, 2);
}

TEST(StackChoice, TheOddImageOfASliceIsNamed) {
  for (const std::size_t odd : {0U, 5U, 9U}) {
    auto images = made_stack({.slices = 3});
    images[odd].columns = 32;
    const std::string message = refusal(images);
    EXPECT_EQ(message.rfind(images[odd].file.string() + ": it has 32 x 64 pixels", 0), 0U)
        << message;
  }
}

TEST(StackChoice, GivenTimesReplaceTheSources) {
  std::vector<double> times;
  for (int p = 0; p < 10; ++p) times.push_back(0.02 + 0.07 * p + 0.001 * p * p);
  auto images = made_stack({});
  append(images, made_stack(oblique({.slices = 1, .phases = 12, .first_series = 50})));
  const Choice choice = choose(images, {.rr_interval_s = 1.0, .frame_times_s = times});
  for (const ImageSet& set : choice.stack.slices) EXPECT_EQ(set.timing.time_s, times);
  EXPECT_EQ(choice.stack.rr_s, 1.0);
  EXPECT_TRUE(told(choice.decisions, "1 view has another number of frames than times"))
      << joined(choice.decisions);
  EXPECT_TRUE(told(choice.decisions, "by the times given")) << joined(choice.decisions);
  // 9 times for 10 frames; times beyond the R-R interval.
  const std::string counts =
      refusal(images, {.frame_times_s = {0, .1, .2, .3, .4, .5, .6, .7, .8}});
  EXPECT_NE(counts.find("9 frame times are given, but a slice of series 1 has 10 frames"),
            std::string::npos)
      << counts;
  const std::string span = refusal(images, {.rr_interval_s = 0.5, .frame_times_s = times});
  std::vector<double> down = times;
  std::swap(down[3], down[4]);
  EXPECT_NE(refusal(images, {.frame_times_s = down}).find("must be numbers that ascend"),
            std::string::npos);
  EXPECT_NE(span.find("span 0.711 s, but the R-R interval is 0.500 s"), std::string::npos) << span;
}

TEST(StackChoice, TheUnseenShareOfTheCycleIsTold) {
  // 20 frames of 30 ms in 900 ms: one third is never seen, less one step.
  const Choice choice = choose(made_stack({.phases = 20, .step_ms = 30}));
  EXPECT_TRUE(told(choice.decisions, "Warning: 33 % of the cycle was never imaged"))
      << joined(choice.decisions);
  EXPECT_FALSE(told(choose(made_stack({.phases = 20})).decisions, "never imaged"));
}

TEST(StackChoice, DoubledFramesWithoutTimesCountOnce) {
  // Every phase stored twice; the contents tell.
  auto images = made_stack({.slices = 4, .phases = 20, .with_trigger = false});
  ImageFiles files = no_files();
  files.fingerprint = [](const DicomImage& image) {
    return std::to_string((static_cast<int>(*image.stamp.instance) - 1) / 2);
  };
  const Choice choice = choose_stack(images, {}, files);
  EXPECT_EQ(choice.phases, 10);
  EXPECT_TRUE(told(choice.decisions, "10 images equal to another were left"))
      << joined(choice.decisions);
  // The whole cycle again; and a beat that is the same forwards and backwards is no doubled one.
  files.fingerprint = [](const DicomImage& image) {
    return std::to_string((static_cast<int>(*image.stamp.instance) - 1) % 10);
  };
  EXPECT_EQ(choose_stack(images, {}, files).phases, 10);
  files.fingerprint = [](const DicomImage& image) {
    return std::to_string(std::abs(static_cast<int>(*image.stamp.instance) - 11));
  };
  EXPECT_EQ(choose_stack(images, {}, files).phases, 20);
  // Slices in which nothing moves are not doubled.
  files.fingerprint = [](const DicomImage&) { return std::string("same"); };
  EXPECT_EQ(choose_stack(images, {}, files).phases, 20);
}

TEST(StackChoice, AnAcquisitionThatWasBrokenOffIsNotMixedIn) {
  auto images = made_stack({.series_per_slice = false});
  for (DicomImage& image : images) image.stamp.acquisition_number = 2;
  auto broken = made_stack({.slices = 1, .phases = 6, .series_per_slice = false, .step_ms = 85});
  for (DicomImage& image : broken) image.stamp.acquisition_number = 1;
  auto all = broken;
  append(all, images);
  const Choice choice = choose(all);
  EXPECT_EQ(choice.stack.slices[0].frames(), 10) << joined(choice.decisions);
  for (const int index : choice.stack.slices[0].images) EXPECT_GE(index, 6);
  EXPECT_TRUE(told(choice.decisions,
                   "Warning: timing of the stack (series 1): the slice was "
                   "acquired 2 times"))
      << joined(choice.decisions);
  // The clock tells it too; of equals the later counts.
  all = images;
  append(all, images);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].stamp.acquisition_number.reset();
    all[i].stamp.acquisition_s = i < images.size() ? 43300 : 43200;
  }
  for (const ImageSet& set : choose(all).stack.slices) {
    EXPECT_EQ(set.frames(), 10);
    for (const int index : set.images) EXPECT_LT(index, 60);
  }
  // Parts of one cycle belong together.
  all = images;
  for (DicomImage& image : all) image.stamp.acquisition_number = *image.stamp.trigger_ms < 440;
  EXPECT_EQ(choose(all).phases, 10);
}

TEST(StackChoice, KindsOfImagesAreNotMixed) {
  auto images = made_stack({.series_per_slice = false});
  auto others = images;
  for (DicomImage& image : images) image.kind = "ORIGINAL\\NORM";
  for (DicomImage& image : others) image.kind = "ORIGINAL\\ND";
  append(images, others);
  const Choice choice = choose(images);
  EXPECT_EQ(choice.phases, 10) << joined(choice.decisions);
  for (const ImageSet& set : choice.stack.slices) {
    EXPECT_EQ(set.kind, "ORIGINAL\\NORM") << "the kind that is met first";
    for (const int index : set.images) EXPECT_LT(index, 60);
  }
  EXPECT_TRUE(told(choice.decisions, "is there in 2 kinds (ImageType)"))
      << joined(choice.decisions);
  EXPECT_FALSE(told(choice.decisions, "NORM")) << "no text of the files";
}

TEST(StackChoice, SeveralBeatsOfUnknownLengthAskForIt) {
  auto images = made_stack({.phases = 96, .step_ms = 50});
  for (DicomImage& image : images) image.stamp.rr_ms.reset();
  EXPECT_NE(refusal(images).find("several heart beats, and name no R-R interval: give it (--rr)"),
            std::string::npos)
      << refusal(images);
  EXPECT_EQ(choose(images, {.rr_interval_s = 0.8}).phases, 16);
}

TEST(StackChoice, AStackPlannedAgainIsAnother) {
  auto images = made_stack({.slices = 8, .first_series = 10});
  append(images, made_stack({.slices = 8, .first_series = 100, .origin = {0, 0, 3}}));
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.grid.size[2], 8);
  for (const ImageSet& set : choice.stack.slices) EXPECT_GE(set.series_number, 100);
  EXPECT_TRUE(
      told(choice.decisions, "3. 8 slices x 10 phases, 8.00 mm apart, axial (series 10-17)"))
      << joined(choice.decisions);
  EXPECT_TRUE(told(choice.decisions, "Warning: possible stack 1 was passed over"));
}

TEST(StackChoice, APartIsNotTakenForTheWhole) {
  // Two series that end and begin at a slice that is missing, and one that stands apart a little.
  auto images = made_stack({.slices = 6, .series_per_slice = false});
  append(images,
         made_stack(
             {.slices = 5, .first_series = 2, .series_per_slice = false, .origin = {0, 0, 56}}));
  Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.size(), 11U) << joined(choice.decisions);
  EXPECT_EQ(choice.stack.grid.size[2], 12);
  EXPECT_TRUE(told(choice.decisions, "Warning: slice 6 is missing within the stack"))
      << joined(choice.decisions);
  images = made_stack({.slices = 6, .series_per_slice = false});
  append(images,
         made_stack(
             {.slices = 5, .first_series = 2, .series_per_slice = false, .origin = {0, 0, 50.5}}));
  choice = choose(images);
  EXPECT_EQ(choice.stack.slices.size(), 11U) << joined(choice.decisions);
  EXPECT_EQ(choice.stack.grid.size[2], 11);
  EXPECT_TRUE(told(choice.decisions,
                   "Warning: the gaps between slices differ from their median by up to 31.2 %; the "
                   "slices were placed evenly, 8.34 mm apart, and lie up to 1.1 mm off."))
      << joined(choice.decisions);
  // With three slices missing a half is refused, and taken where a person asks for it.
  images = made_stack({.slices = 6, .series_per_slice = false});
  append(images,
         made_stack(
             {.slices = 5, .first_series = 2, .series_per_slice = false, .origin = {0, 0, 72}}));
  const std::string message = refusal(images);
  EXPECT_NE(
      message.find("a part of it can be taken with --stack 2, beyond which lie 5 of its slices"),
      std::string::npos)
      << message;
  EXPECT_EQ(choose(images, {.stack = 2}).stack.slices.size(), 6U);
}

TEST(StackChoice, WhatLiesBeyondTheEndsIsTold) {
  auto images = made_stack({.slices = 8, .series_per_slice = false});
  append(images, made_stack({.slices = 1, .first_series = 2, .origin = {0, 0, 80}}));
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.size(), 8U) << joined(choice.decisions);
  EXPECT_TRUE(told(choice.decisions,
                   "Warning: 1 parallel slice lies beyond the ends of the stack and was left (1 "
                   "behind slice 7): look whether the heart goes on there."))
      << joined(choice.decisions);
}

TEST(StackChoice, WhereTheBestPlaneIsNoStackTheNextIsTaken) {
  auto uneven = made_stack({.slices = 12, .first_series = 100, .series_per_slice = false});
  for (DicomImage& image : uneven) {
    image.position_lps.z() += std::fmod(std::round(image.position_lps.z() / 8), 3) * 2.5;
  }
  auto images = made_stack(coronal({.slices = 8}));
  append(images, uneven);
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.size(), 8U) << joined(choice.decisions);
  EXPECT_TRUE(told(choice.decisions,
                   "Warning: possible stack 1 was passed over: the slices of the "
                   "stack are unevenly spaced"));
  // If nothing does, the error lists what there is.
  for (DicomImage& image : images) {
    if (image.series_number < 100) image.position_lps *= 1 + 0.05 * image.series_number;
  }
  const std::string message = refusal(images);
  EXPECT_NE(message.find("--stack or --series"), std::string::npos) << message;
  EXPECT_NE(message.find("2. 8 slices"), std::string::npos) << message;
}

TEST(StackChoice, OfFewFramesNoneIsLeftUntold) {
  auto images = made_stack({.slices = 5, .phases = 7});
  append(images, made_stack({.slices = 1, .phases = 6, .first_series = 6, .origin = {0, 0, 40}}));
  EXPECT_EQ(choose(images).phases, 7);
  EXPECT_TRUE(told(choose(images).decisions, "(series 6): fewer frames than other slices have"));
  append(images, made_stack({.slices = 6, .phases = 6, .first_series = 7, .origin = {0, 0, 48}}));
  const Choice choice = choose(images);
  EXPECT_EQ(choice.phases, 6);
  EXPECT_TRUE(told(choice.decisions, "(series 1-5): more frames than other slices have"))
      << joined(choice.decisions);
}

TEST(StackChoice, ImagesWithoutAnOrderAreNotCalledOnePhase) {
  auto images = made_stack({.with_trigger = false});
  for (DicomImage& image : images) image.stamp.instance.reset();
  EXPECT_NE(refusal(images).find("10 images of a slice, but nothing tells their order in time"),
            std::string::npos)
      << refusal(images);
  EXPECT_NE(refusal(made_stack({.phases = 1})).find("only one phase of each slice"),
            std::string::npos);
}

TEST(StackChoice, RestAndStressAreNotMixed) {
  auto images = made_stack({.slices = 8, .first_series = 10, .rr_ms = 844});
  append(images, made_stack({.slices = 5, .first_series = 100, .rr_ms = 600}));
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.size(), 8U);
  for (const ImageSet& set : choice.stack.slices) EXPECT_LT(set.series_number, 100);
  EXPECT_FALSE(told(choice.decisions, "of two acquisitions")) << joined(choice.decisions);
  // Only both together are the whole stack: that is told.
  images = made_stack({.slices = 6, .first_series = 10, .rr_ms = 844});
  append(images,
         made_stack({.slices = 5, .first_series = 100, .rr_ms = 600, .origin = {0, 0, 24}}));
  EXPECT_TRUE(told(choose(images).decisions, "may be of two acquisitions"));
}

TEST(StackChoice, TheReasonToldIsTheRule) {
  auto images = made_stack({.first_series = 5, .series_per_slice = false});
  append(images, made_stack({.first_series = 6, .series_per_slice = false}));
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.front().series_number, 6);
  EXPECT_TRUE(told(choice.decisions, "because it is equal to the next and of a later series"))
      << joined(choice.decisions);
}

}  // namespace
}  // namespace beatlas::ingest::stack_choice_tests
