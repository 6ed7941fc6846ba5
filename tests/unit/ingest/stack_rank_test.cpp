// Which of several possible stacks is taken for the heart.

#include "pipeline/ingest/stack_rank.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/ingest/heart_axis.h"
#include "pipeline/ingest/stack_choice.h"
#include "tests/unit/ingest/made_images.h"

namespace beatlas::ingest::stack_rank_tests {
namespace {

using test::append;
using test::joined;
using test::made_stack;
using test::told;

Choice choose(const std::vector<DicomImage>& images, const IngestOptions& options = {}) {
  return choose_stack(images, options, test::no_files());
}

// Leftwards, forwards and down, as a left ventricle lies.
const Vec3 kAxis = Vec3(0.6, -0.6, -0.53).normalized();

/// Slices across an axis.
std::vector<DicomImage> across(const Vec3& axis, test::MadeStack made) {
  made.row = axis.unitOrthogonal();
  made.column = axis.cross(made.row);
  return made_stack(made);
}

/// One slice that holds an axis, turned about it against the plane that also holds the patient's.
std::vector<DicomImage> view(const Vec3& axis, double turn_deg, int series) {
  const double turn = turn_deg * std::numbers::pi / 180;
  const Vec3 side = axis.cross(Vec3::UnitZ()).normalized();
  return across(std::cos(turn) * side + std::sin(turn) * axis.cross(side),
                {.slices = 1, .first_series = series});
}

TEST(StackRank, TheShortAxisWinsOverMoreSlicesWhereViewsTellIt) {
  // Neither lies along the patient's axes.
  auto images = across(Vec3(1, 1, 1).normalized(), {.slices = 20, .first_series = 1});
  append(images, across(kAxis, {.slices = 9, .first_series = 50, .gap_mm = 10}));
  const auto slices = [&] { return choose(images).stack.slices.size(); };
  EXPECT_EQ(slices(), 20U) << "nothing tells which is which";
  append(images, view(kAxis, 60, 70));
  EXPECT_EQ(slices(), 20U) << "one view has no axis";
  append(images, view(kAxis, 75, 71));
  EXPECT_EQ(slices(), 20U) << "nor have two that are hardly turned";
  append(images, view(kAxis, 120, 72));
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.size(), 9U);
  EXPECT_TRUE(told(choice.decisions,
                   "chosen because it lies across the axis along which the long-axis views meet"))
      << joined(choice.decisions);
  EXPECT_EQ(choice.views.size(), 3U);
  EXPECT_FALSE(told(choice.decisions, "do not tell for certain")) << joined(choice.decisions);
}

TEST(StackRank, ViewsThatHappenToHoldThePatientsAxisMakeNoAxialStackAShortAxis) {
  // The view at 0 degrees and the one through the right ventricle both hold z.
  auto images = across(kAxis, {.slices = 6, .first_series = 50, .gap_mm = 17});
  append(images, made_stack({.slices = 14, .first_series = 100}));
  for (const double turn_deg : {0.0, 60.0, 120.0}) {
    append(images, view(kAxis, turn_deg, 70 + static_cast<int>(turn_deg)));
  }
  append(images, across(Vec3(0.99, 0.1, 0).normalized(), {.slices = 1, .first_series = 80}));
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.size(), 6U) << joined(choice.decisions);
  EXPECT_FALSE(told(choice.decisions, "do not tell for certain")) << joined(choice.decisions);
  EXPECT_EQ(choose(images, {.stack = 2}).stack.slices.size(), 14U);
}

TEST(StackRank, WithoutViewsAnObliqueStackIsTakenAndTheOtherTold) {
  auto images = made_stack({.slices = 7, .first_series = 100});
  append(images, across(kAxis, {.slices = 6, .first_series = 50}));
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.size(), 6U) << joined(choice.decisions);
  EXPECT_TRUE(told(choice.decisions, "it is oblique as a short axis is"))
      << joined(choice.decisions);
  EXPECT_TRUE(told(choice.decisions, "take the other with --stack 2")) << joined(choice.decisions);
  EXPECT_FALSE(told(choose(images, {.stack = 1}).decisions, "do not tell for certain"));
}

TEST(StackRank, EvidenceIsTheShareOfViewsThatMeet) {
  const auto evidence = [](const std::vector<std::vector<DicomImage>>& views) {
    auto images = across(kAxis, {.first_series = 10});
    for (const auto& one : views) append(images, one);
    const std::vector<Plane> planes = group_planes(images, test::no_files());
    return axis_evidence(planes.front(), planes);
  };
  const auto turned_view = [](double turn_deg) { return view(kAxis, turn_deg, 1); };
  EXPECT_NEAR(evidence({turned_view(0), turned_view(60), turned_view(120)}), 1, 1e-9);
  EXPECT_EQ(evidence({turned_view(0)}), 0);
  EXPECT_EQ(evidence({turned_view(0), turned_view(20)}), 0);
  EXPECT_EQ(evidence({turned_view(0), across(kAxis, {.slices = 1, .pixels = 32})}), 0)
      << "a slice parallel to the stack is no view";
  // One view of three lies elsewhere: of three pairs one meets.
  const double most = evidence(
      {turned_view(0), turned_view(90), across(Vec3(1, 1, 1).normalized(), {.slices = 1})});
  EXPECT_GT(most, 0.2);
  EXPECT_LT(most, 0.8);
}

template <class Change>
std::vector<DicomImage> changed(std::vector<DicomImage> images, const Change& change) {
  for (DicomImage& image : images) change(image);
  return images;
}

TEST(StackRank, SecondaryCopiesTakeNoPlaceOfOriginals) {
  const auto copies = [](DicomImage& image) { image.provenance = Provenance::Secondary; };
  // A series a slice, one for all, and in the series of the originals, with more frames.
  for (const bool one_series : {false, true}) {
    auto images = made_stack({.slices = 6});
    append(
        images,
        changed(
            made_stack(
                {.slices = 6, .phases = 20, .first_series = 60, .series_per_slice = !one_series}),
            copies));
    const Choice choice = choose(images);
    for (const ImageSet& set : choice.stack.slices) EXPECT_LT(set.series_number, 60);
    EXPECT_FALSE(told(choice.decisions, "no originals")) << joined(choice.decisions);
  }
  auto images = changed(made_stack({.slices = 6}), copies);
  append(images, made_stack({.slices = 6}));
  for (const ImageSet& set : choose(images).stack.slices) {
    for (const int index : set.images) EXPECT_GE(index, 60);
  }
  // Nor with more slices; only where there is nothing else, and that is told.
  images = changed(made_stack({.slices = 9, .first_series = 60}), copies);
  EXPECT_TRUE(told(choose(images).decisions,
                   "Warning: there are no originals of series 60-68, which are secondary copies"));
  append(images, made_stack({.slices = 6}));
  EXPECT_EQ(choose(images).stack.slices.size(), 6U);
}

TEST(StackRank, DerivedImagesComeBehindOriginals) {
  const auto derived = [](DicomImage& image) { image.provenance = Provenance::Derived; };
  auto images = made_stack({.slices = 6});
  append(images, changed(made_stack({.slices = 6, .phases = 20, .first_series = 60}), derived));
  const Choice choice = choose(images);
  for (const ImageSet& set : choice.stack.slices) EXPECT_LT(set.series_number, 60);
  // Of a slice that is there as a derived image only, that is taken and told.
  std::erase_if(images, [](const DicomImage& image) { return image.series_number == 3; });
  const Choice mended = choose(images);
  EXPECT_EQ(mended.stack.slices.size(), 6U);
  EXPECT_TRUE(
      told(mended.decisions, "Warning: there are no originals of series 62, which were calculated"))
      << joined(mended.decisions);
}

const test::MadeStack kTagged{.first_series = 60, .echo_ms = 3.9, .sequence = "GR\nSP"};

TEST(StackRank, TaggingTakesNoPlaceOfTheCineThoughItIsLater) {
  // A stack; and one view of it at the place of the cine's, another beside it.
  auto images = across(kAxis, {.slices = 6});
  append(images, across(kAxis, kTagged));
  for (const int turn_deg : {0, 60, 120}) append(images, view(kAxis, turn_deg, 20 + turn_deg));
  const auto tag = [](DicomImage& image) {
    image.contrast = {.sequence = kTagged.sequence, .echo_ms = kTagged.echo_ms};
  };
  append(images, changed(view(kAxis, 60, 200), tag));
  append(images, changed(view(kAxis, 65, 201), tag));
  const Choice choice = choose(images);
  for (const ImageSet& set : choice.stack.slices) EXPECT_LT(set.series_number, 20);
  ASSERT_EQ(choice.views.size(), 3U) << joined(choice.decisions);
  EXPECT_EQ(choice.views[1].slices.front().series_number, 80);
  EXPECT_TRUE(told(choice.decisions, "series 60-65, 200, 201")) << joined(choice.decisions);
  // Without views nothing but the spoiled sequence tells which is which.
  images = across(kAxis, {.slices = 6});
  append(images, across(kAxis, kTagged));
  for (const ImageSet& set : choose(images).stack.slices) EXPECT_LT(set.series_number, 60);
}

TEST(StackRank, AShortStackOfAnotherContrastDoesNotMakeItTheExams) {
  // Tagging in four directions, but the cine has the whole heart.
  auto images = across(kAxis, {.slices = 10});
  auto tagged = kTagged;
  tagged.slices = 3;
  append(images, across(kAxis, tagged));
  for (const int turn_deg : {0, 60, 120}) {
    append(images, changed(view(kAxis, turn_deg, 70 + turn_deg), [](DicomImage& image) {
             image.contrast = {.sequence = kTagged.sequence, .echo_ms = kTagged.echo_ms};
           }));
  }
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.size(), 10U) << joined(choice.decisions);
  for (const ImageSet& set : choice.stack.slices) EXPECT_LT(set.series_number, 60);
  EXPECT_EQ(choice.views.size(), 3U) << "views of another contrast are better than none";
}

TEST(StackRank, AnInversionScoutTakesNoSliceOfTheCine) {
  const auto scout = [](const Contrast& contrast) {
    auto out = made_stack({.slices = 1, .phases = 35, .first_series = 60, .origin = {0, 0, 16}});
    for (DicomImage& image : out) image.contrast = contrast;
    return out;
  };
  const Contrast cine{.sequence = "GR\nSK", .family = "tfi", .echo_ms = 1.5, .flip_deg = 58};
  const auto stack = changed(made_stack({}), [&](DicomImage& image) { image.contrast = cine; });
  for (int what = 0; what < 4; ++what) {
    Contrast other = cine;
    if (what == 0) other.inversion_ms = 82;
    if (what == 1) other.flip_deg = 30;
    if (what == 2) other.family = "tfl";
    if (what == 3) other.sequence = "GR\\IR\nSK\\MP";
    auto images = stack;
    append(images, scout(other));
    for (const ImageSet& set : choose(images).stack.slices) EXPECT_LT(set.series_number, 60);
  }
  // A repeat with trimmed flip angle and echo time is one of the cine, and has more frames.
  Contrast trimmed = cine;
  trimmed.flip_deg = 45;
  trimmed.echo_ms = 1.42;
  auto images = stack;
  append(images, scout(trimmed));
  EXPECT_EQ(choose(images).stack.slices[2].series_number, 60);
}

TEST(StackRank, FlowIsToldByItsPhaseImagesWhateverTheirNumber) {
  for (const bool as_many : {true, false}) {
    auto images = across(kAxis, {.slices = 4});
    test::MadeStack flow{
        .slices = 8, .phases = 20, .first_series = 50, .series_per_slice = false, .echo_ms = 2.5};
    append(images, across(Vec3(1, 1, 1).normalized(), flow));
    flow.first_series = 1050;
    flow.magnitude = false;
    auto velocity = across(Vec3(1, 1, 1).normalized(), flow);
    if (!as_many) {
      std::erase_if(velocity,
                    [](const DicomImage& image) { return *image.stamp.trigger_ms > 500; });
    }
    append(images, velocity);
    const Choice choice = choose(images);
    EXPECT_EQ(choice.stack.slices.size(), 4U) << joined(choice.decisions);
    EXPECT_TRUE(told(choice.decisions, "oblique, flow (series 50)")) << joined(choice.decisions);
    // Of another study they tell nothing.
    for (DicomImage& image : images) {
      if (!image.magnitude) image.study_uid = "another";
    }
    EXPECT_EQ(choose(images).stack.slices.size(), 8U);
  }
}

TEST(StackRank, ContrastsAreComparedByWhatTellsThemApart) {
  const Contrast cine{.sequence = "GR\nSK", .family = "tfi", .echo_ms = 1.5, .flip_deg = 58};
  const auto with = [&](auto change) {
    Contrast out = cine;
    change(out);
    return out;
  };
  EXPECT_TRUE(same_contrast(cine, with([](Contrast& c) { c.family.clear(); })));
  EXPECT_TRUE(same_contrast(cine, with([](Contrast& c) { c.flip_deg = 0; })));
  EXPECT_FALSE(same_contrast(cine, with([](Contrast& c) { c.echo_ms = 1.8; })));
  EXPECT_TRUE(one_protocol(cine, with([](Contrast& c) { c.echo_ms = 1.8; })));
  EXPECT_FALSE(one_protocol(cine, with([](Contrast& c) { c.echo_ms = 3.9; })));
  EXPECT_FALSE(one_protocol(cine, with([](Contrast& c) { c.flip_deg = 10; })));
  EXPECT_TRUE(one_protocol({.echo_ms = -1}, {.echo_ms = -1})) << "whatever a file says";
  EXPECT_TRUE(is_spoiled({.sequence = "GR\nMP\\SP"}));
  EXPECT_FALSE(is_spoiled({.sequence = "GR\nOSP\\SS"}));
}

TEST(StackRank, SlicesOfSeveralFramesOfReferenceAreNotPutInOneStack) {
  // Half of a stack, all of it half a step on, and one slice again.
  auto images = across(kAxis, {.slices = 6});
  for (DicomImage& image : images)
    image.frame_of_reference_uid = image.series_number > 2 ? "b" : "a";
  const Choice half = choose(images);
  EXPECT_EQ(half.stack.slices.size(), 4U) << joined(half.decisions);
  EXPECT_TRUE(told(half.decisions,
                   "Warning: series 1, 2 name another frame of reference than the stack, as if the "
                   "patient had been moved, and were left, with 2 slices that are parallel to it"))
      << joined(half.decisions);
  images = across(kAxis, {.slices = 6});
  append(images,
         across(kAxis, {.slices = 6, .first_series = 20, .origin = 4 * kAxis, .frame = "b"}));
  const Choice twice = choose(images);
  EXPECT_EQ(twice.stack.slices.size(), 6U) << joined(twice.decisions);
  EXPECT_NEAR(twice.stack.grid.spacing_mm()[2], 8, 1e-6);
  images = across(kAxis, {.slices = 6});
  append(images,
         across(kAxis, {.slices = 1, .first_series = 20, .origin = 16 * kAxis, .frame = "b"}));
  for (const ImageSet& set : choose(images).stack.slices) EXPECT_LT(set.series_number, 20);
  // Views speak for a stack of their own frame, but not for a part of one against a whole.
  for (const int slices : {4, 6}) {
    images = across(kAxis, {.slices = slices});
    append(images, across(kAxis, {.slices = 6, .first_series = 20, .frame = "b"}));
    append(images, view(kAxis, 0, 40));
    append(images, view(kAxis, 90, 41));
    const int first = choose(images).stack.slices.front().series_number;
    EXPECT_EQ(first >= 20, slices == 4) << first;
  }
  // A guest of another frame is none, one that does not say is.
  images = across(kAxis, {.slices = 6});
  append(
      images,
      across(kAxis,
             {.slices = 1, .first_series = 20, .origin = 48 * kAxis, .pixels = 80, .frame = "b"}));
  EXPECT_EQ(choose(images).stack.slices.size(), 6U);
  images = changed(images, [](DicomImage& image) {
    if (image.frame_of_reference_uid == "b") image.frame_of_reference_uid.clear();
  });
  EXPECT_EQ(choose(images).stack.slices.size(), 7U);
}

TEST(StackRank, ViewsOfAnotherFrameOfReferenceAreLeftAndTold) {
  auto images = across(kAxis, {.slices = 6});
  for (const int turn_deg : {0, 60, 120}) {
    append(images, changed(view(kAxis, turn_deg, 20 + turn_deg),
                           [](DicomImage& image) { image.frame_of_reference_uid = "b"; }));
  }
  const Choice choice = choose(images);
  EXPECT_TRUE(choice.views.empty());
  EXPECT_TRUE(told(choice.decisions, "Warning: series 20, 80, 140 name another frame"))
      << joined(choice.decisions);
}

TEST(StackRank, FramesOfReferenceThatTellNothingKeepNothingApart) {
  // One a series, one an image, and where no frame has a stack.
  auto images = across(kAxis, {.slices = 6});
  for (DicomImage& image : images) image.frame_of_reference_uid = image.series_uid;
  const Choice a_series = choose(images);
  EXPECT_EQ(a_series.stack.slices.size(), 6U);
  EXPECT_TRUE(told(a_series.decisions, "Warning: every series names a frame of reference"));
  for (std::size_t i = 0; i < images.size(); ++i) {
    images[i].frame_of_reference_uid = std::to_string(i);
  }
  const Choice an_image = choose(images);
  EXPECT_EQ(an_image.stack.slices.size(), 6U);
  EXPECT_FALSE(told(an_image.decisions, "frame")) << joined(an_image.decisions);
  images = across(kAxis, {.slices = 4});
  for (DicomImage& image : images)
    image.frame_of_reference_uid = image.series_number > 2 ? "b" : "a";
  const Choice joint = choose(images);
  EXPECT_EQ(joint.stack.slices.size(), 4U);
  EXPECT_TRUE(told(joint.decisions, "Warning: the slices name several frames of reference, none"))
      << joined(joint.decisions);
}

TEST(StackRank, RestAndStressArePartedHoweverSeriesAreNumbered) {
  for (const int step : {1, 1000}) {
    for (const int slices : {5, 6}) {
      auto images = across(kAxis, {.rr_ms = 850});
      append(images, across(kAxis, {.slices = slices, .first_series = 20, .rr_ms = 470}));
      for (DicomImage& image : images) {
        image.series_number *= step;
        image.series_uid = std::to_string(image.series_number);
      }
      const Choice choice = choose(images);
      ASSERT_EQ(choice.stack.slices.size(), 6U);
      const bool rest = choice.stack.slices.front().series_number < 20 * step;
      EXPECT_EQ(rest, slices == 5) << "of equals the later";
      for (const ImageSet& set : choice.stack.slices) {
        EXPECT_EQ(set.series_number < 20 * step, rest) << joined(choice.decisions);
      }
      // The other is there to be asked for, and told if it is as large.
      const Choice other = choose(images, {.stack = slices == 5 ? 3 : 2});
      for (const ImageSet& set : other.stack.slices) {
        EXPECT_EQ(set.series_number < 20 * step, !rest) << joined(other.decisions);
      }
      EXPECT_EQ(told(choice.decisions,
                     "Warning: possible stack 2 is as large and of another heart rate (R-R 850 "
                     "instead of 470 ms)"),
                slices == 6)
          << joined(choice.decisions);
    }
  }
}

TEST(StackRank, AStackThatWasTakenAgainIsListedWhole) {
  auto images = across(kAxis, {});
  append(images, across(kAxis, {.first_series = 7}));
  const Choice choice = choose(images);
  EXPECT_EQ(choice.stack.slices.front().series_number, 7) << joined(choice.decisions);
  EXPECT_EQ(choose(images, {.stack = 2}).stack.slices.back().series_number, 6)
      << joined(choice.decisions);
}

}  // namespace
}  // namespace beatlas::ingest::stack_rank_tests
