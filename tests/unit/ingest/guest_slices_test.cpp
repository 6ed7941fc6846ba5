// Stacks whose slices do not all share one field of view.

#include "pipeline/ingest/guest_slices.h"

#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "pipeline/ingest/stack_choice.h"
#include "runtime/base/error.h"
#include "tests/unit/ingest/made_images.h"

namespace beatlas::ingest::guest_slices_tests {
namespace {

using test::append;
using test::joined;
using test::made_stack;
using test::told;

Choice choose(const std::vector<DicomImage>& images) {
  return choose_stack(images, {}, test::no_files());
}

/// Series of the stack's slices, in their order.
std::vector<int> series_of(const Choice& choice) {
  std::vector<int> out;
  for (const ImageSet& set : choice.stack.slices) out.push_back(set.series_number);
  return out;
}

/// first, first + 1, ... last.
std::vector<int> from_to(int first, int last) {
  std::vector<int> out;
  for (int i = first; i <= last; ++i) out.push_back(i);
  return out;
}

std::vector<int> with(std::vector<int> series, std::size_t at, int instead) {
  series[at] = instead;
  return series;
}

template <class Change>
std::vector<DicomImage> with_changed(std::vector<DicomImage> images, const std::set<int>& series,
                                     const Change& change) {
  for (DicomImage& image : images) {
    if (series.count(image.series_number) > 0) change(image);
  }
  return images;
}

void move(DicomImage& image) { image.position_lps += Vec3(6, -5, 0); }
void refine(DicomImage& image) {
  image.columns = image.rows = 128;
  image.column_step_mm = image.row_step_mm = 0.75;
}
/// About the row through the image's middle.
void tilt(DicomImage& image, double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  const Vec3 middle = image.position_lps + Vec3(0, 47.25, 0);
  image.column_lps = Vec3(0, std::cos(angle), std::sin(angle));
  image.position_lps = middle - 47.25 * image.column_lps;
}
/// About the image's middle.
void turn(DicomImage& image, double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  const Vec3 middle = image.position_lps + Vec3(47.25, 47.25, 0);
  image.row_lps = Vec3(std::cos(angle), std::sin(angle), 0);
  image.column_lps = Vec3(-std::sin(angle), std::cos(angle), 0);
  image.position_lps = middle - 47.25 * (image.row_lps + image.column_lps);
}

/// One slice of its own series.
std::vector<DicomImage> slice_at(double mm, int series, int phases = 10) {
  return made_stack({.slices = 1, .phases = phases, .first_series = series, .origin = {0, 0, mm}});
}
std::vector<DicomImage> moved(std::vector<DicomImage> images) {
  for (DicomImage& image : images) move(image);
  return images;
}
std::vector<DicomImage> refined(std::vector<DicomImage> images) {
  for (DicomImage& image : images) refine(image);
  return images;
}

TEST(GuestSlices, OfAnotherFieldOfViewAreOfTheStack) {
  const auto stack = made_stack({.slices = 9});
  const auto expect_whole = [](const Choice& choice, const std::string& words) {
    EXPECT_EQ(choice.stack.grid.size, (Index3{64, 64, 9})) << joined(choice.decisions);
    EXPECT_NEAR(choice.stack.grid.spacing_mm()[2], 8, 1e-6);
    EXPECT_EQ(series_of(choice), from_to(1, 9));
    EXPECT_TRUE(told(choice.decisions, words)) << joined(choice.decisions);
    EXPECT_TRUE(choice.views.empty());
  };
  // An inner slice, an end of the stack, and both.
  for (const std::set<int>& series : {std::set<int>{5}, std::set<int>{9}, std::set<int>{1, 2, 7}}) {
    expect_whole(choose(with_changed(stack, series, move)), "7.8 mm beside the others', and w");
    expect_whole(choose(with_changed(stack, series, refine)),
                 "resampled to the pixels of the stack (series ");
    expect_whole(choose(with_changed(stack, series, [](DicomImage& image) { tilt(image, 1); })),
                 "0.0 mm beside the others' and which is tilted by 1.0 degrees, and w");
    expect_whole(choose(with_changed(stack, series, [](DicomImage& image) { turn(image, 30); })),
                 "0.0 mm beside the others', and w");
  }
}

// Whichever of two fields of view leads the stack that is gathered of both.
TEST(GuestSlices, FieldsOfViewInTurnsAreOneStack) {
  const auto stack = made_stack({.slices = 12});
  for (const std::set<int>& series :
       {std::set<int>{1, 3, 5, 7, 9, 11}, std::set<int>{2, 4, 6, 8, 10, 12}}) {
    const Choice choice = choose(with_changed(stack, series, move));
    EXPECT_EQ(choice.stack.grid.size[2], 12) << joined(choice.decisions);
    EXPECT_EQ(series_of(choice), from_to(1, 12));
  }
}

TEST(GuestSlices, EachOfAFieldOfViewOfItsOwnAreAStack) {
  auto each = made_stack({.slices = 9});
  for (DicomImage& image : each) image.position_lps.x() += 3 * (image.series_number % 5);
  for (const bool other_pixels : {false, true}) {
    for (DicomImage& image : each) {
      image.column_step_mm *= other_pixels ? 1 + 0.01 * image.series_number : 1;
    }
    EXPECT_EQ(series_of(choose(each)), from_to(1, 9));
    // Stills beside them, and a short series of another contrast.
    auto more = each;
    append(more, made_stack({.slices = 10, .phases = 1, .first_series = 50, .gap_mm = 7}));
    EXPECT_EQ(series_of(choose(more)), from_to(1, 9));
    append(
        more,
        made_stack(
            {.slices = 3, .first_series = 70, .gap_mm = 24, .echo_ms = 3.8, .sequence = "GR\nSP"}));
    const Choice choice = choose(more);
    EXPECT_EQ(series_of(choice), from_to(1, 9)) << joined(choice.decisions);
  }
  // Some of them share one, but make no stack.
  auto some = made_stack({.slices = 9});
  for (DicomImage& image : some) {
    const int k = image.series_number - 1;
    if (k != 0 && k != 3 && k != 4 && k != 8) turn(image, 0.3 * k);
  }
  EXPECT_EQ(series_of(choose(some)), from_to(1, 9));
}

// However its position is rounded.
TEST(GuestSlices, ASliceTakenAgainCountsIfItIsAsComplete) {
  for (const double off : {-0.01, 0.0, 0.01}) {
    for (const int series : {11, 50}) {
      // The same field of view: the later.
      auto images = made_stack({.slices = 9});
      append(images, slice_at(32 + off, series));
      EXPECT_EQ(series_of(choose(images)), with(from_to(1, 9), 4, series)) << off;
      // It was broken off.
      images = made_stack({.slices = 9, .phases = 25});
      append(images, slice_at(32 + off, series, 12));
      EXPECT_EQ(series_of(choose(images)), from_to(1, 9)) << off;
      // Another field of view: the stack's own, unless that was broken off.
      for (const bool finer : {false, true}) {
        images = made_stack({.slices = 9, .phases = 25});
        const auto again = slice_at(32 + off, series, 25);
        append(images, finer ? refined(again) : moved(again));
        const Choice choice = choose(images);
        EXPECT_EQ(series_of(choice), from_to(1, 9)) << joined(choice.decisions);
        std::erase_if(images, [](const DicomImage& image) {
          return image.series_number == 5 && *image.stamp.instance > 9;
        });
        EXPECT_EQ(series_of(choose(images)), with(from_to(1, 9), 4, series)) << off;
      }
    }
  }
}

TEST(GuestSlices, OfSeveralTheBestCounts) {
  const auto stack = made_stack({.slices = 8, .phases = 25});
  // At the next step: of fewer frames, of more.
  auto images = stack;
  append(images, moved(slice_at(64, 20, 13)));
  append(images, refined(slice_at(64, 30, 25)));
  EXPECT_EQ(series_of(choose(images)), with(from_to(1, 9), 8, 30));
  images = stack;
  append(images, moved(slice_at(63.4, 20, 13)));
  append(images, refined(slice_at(64, 30, 25)));
  EXPECT_EQ(series_of(choose(images)), with(from_to(1, 9), 8, 30));
  // Of as many frames the later.
  images = stack;
  append(images, moved(slice_at(64, 20, 25)));
  append(images, refined(slice_at(64, 30, 25)));
  EXPECT_EQ(series_of(choose(images)), with(from_to(1, 9), 8, 30));
}

TEST(GuestSlices, OfAnotherAcquisitionAreNone) {
  // Stress: another heart rate. A scout of few frames. Both were fine without.
  auto images = made_stack({.slices = 9, .phases = 25, .rr_ms = 844});
  append(images, refined(made_stack({.slices = 5,
                                     .phases = 25,
                                     .first_series = 100,
                                     .gap_mm = 20,
                                     .rr_ms = 600,
                                     .origin = {0, 0, -8}})));
  auto scout = slice_at(-8, 50, 8);
  for (DicomImage& image : scout) tilt(image, 2.9);
  append(images, scout);
  EXPECT_EQ(series_of(choose(images)), from_to(1, 9));
}

TEST(GuestSlices, DoNotDecideWhichStackIsTaken) {
  auto images = made_stack(
      {.slices = 10, .row = Vec3(std::sqrt(0.5), std::sqrt(0.5), 0), .column = -Vec3::UnitZ()});
  append(images, made_stack({.slices = 9, .first_series = 30}));
  append(images, refined(slice_at(-8, 40)));
  append(images, refined(slice_at(72, 41)));
  EXPECT_EQ(series_of(choose(images)), from_to(1, 10));
  // Two acquisitions of two fields of view, each between the slices of the other: the later.
  images = made_stack({.slices = 9, .series_per_slice = false});
  append(images,
         moved(made_stack(
             {.slices = 9, .first_series = 2, .series_per_slice = false, .origin = {0, 0, 4}})));
  const Choice choice = choose(images);
  EXPECT_EQ(series_of(choice), std::vector<int>(9, 2)) << joined(choice.decisions);
  EXPECT_NEAR(choice.stack.grid.spacing_mm()[2], 8, 1e-6);
  EXPECT_TRUE(told(choice.decisions, "because it repeats an equal stack in another field of view"));
  // The same, taken again at the same places.
  images = made_stack({.slices = 9});
  append(images, refined(made_stack({.slices = 9, .first_series = 30})));
  EXPECT_EQ(series_of(choose(images)), from_to(30, 38));
}

// Repeats of single slices, each planned anew, lie closer to each other than slices of a stack.
TEST(GuestSlices, RepeatsInSeveralFieldsOfViewAreNoStack) {
  auto images = made_stack({.slices = 3, .gap_mm = 20});
  for (int n = 0; n < 4; ++n) {
    auto repeat = slice_at(20 + 2.5 * n, 10 + n);
    for (DicomImage& image : repeat) image.position_lps.x() += 3 * (n + 1);
    append(images, repeat);
  }
  EXPECT_EQ(series_of(choose(images)), from_to(1, 3));
  // All at one place, a little beside each other.
  images = slice_at(16, 1);
  for (int n = 0; n < 3; ++n) {
    auto repeat = slice_at(16, 10 + n);
    for (DicomImage& image : repeat) image.position_lps.x() += n < 2 ? 0.12 * (n + 1) : 6;
    append(images, repeat);
  }
  EXPECT_THROW((void)choose(images), Error);
}

// A guest must not cost the stack that is whole without it.
TEST(GuestSlices, ThatLackTooMuchOfTheCycleAreLeft) {
  auto images = made_stack({.slices = 9, .phases = 20});
  auto guest = refined(slice_at(72, 50, 20));
  for (DicomImage& image : guest) {
    image.stamp.trigger_ms = 22 * (*image.stamp.instance - 1);
  }
  append(images, guest);
  const Choice choice = choose(images);
  EXPECT_EQ(series_of(choice), from_to(1, 9)) << joined(choice.decisions);
}

TEST(GuestSlices, AcquiredAmongEachOtherAreOneStack) {
  auto images = made_stack({.slices = 9});
  for (DicomImage& image : images) {
    if (image.series_number % 2 == 0) tilt(image, 1);
  }
  EXPECT_EQ(series_of(choose(images)), from_to(1, 9));
}

TEST(GuestSlices, ThatAreNoneOfTheStackAreNoViews) {
  auto images = made_stack({.slices = 9});
  // Between two slices; of another contrast one step beyond the end; beside the heart.
  append(images, refined(slice_at(20, 50)));
  append(images, refined(made_stack({.slices = 1,
                                     .first_series = 60,
                                     .origin = {0, 0, 72},
                                     .echo_ms = 3.8,
                                     .sequence = "GR\nSP"})));
  append(images, made_stack({.slices = 1, .first_series = 70, .origin = {40, 0, 72}}));
  append(images, made_stack({.slices = 1,
                             .first_series = 80,
                             .row = Vec3(std::sqrt(0.5), std::sqrt(0.5), 0),
                             .column = -Vec3::UnitZ()}));
  const Choice choice = choose(images);
  EXPECT_EQ(series_of(choice), from_to(1, 9));
  ASSERT_EQ(choice.views.size(), 1U) << joined(choice.decisions);
  EXPECT_EQ(choice.views.front().slices.front().series_number, 80);
  EXPECT_TRUE(told(choice.decisions, "outdoes (series 50, 60, 70)")) << joined(choice.decisions);
}

TEST(GuestSlices, OfAFieldAboutTheSameMiddleFitHoweverSmall) {
  const auto zoom = [](DicomImage& image) {  // 33 of 64 pixels each way
    image.position_lps += Vec3(15 * 1.5, 15 * 1.5, 0);
    image.columns = image.rows = 34;
  };
  EXPECT_EQ(series_of(choose(with_changed(made_stack({.slices = 9}), {5}, zoom))), from_to(1, 9));
}

}  // namespace
}  // namespace beatlas::ingest::guest_slices_tests
