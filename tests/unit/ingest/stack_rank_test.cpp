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
  Plane plane;
  plane.row_lps = kAxis.unitOrthogonal();
  plane.column_lps = kAxis.cross(plane.row_lps);
  const auto normal = [](double turn_deg) {
    const auto image = view(kAxis, turn_deg, 1).front();
    return image.row_lps.cross(image.column_lps);
  };
  EXPECT_NEAR(axis_evidence(plane, {normal(0), normal(60), normal(120)}), 1, 1e-9);
  EXPECT_EQ(axis_evidence(plane, {normal(0)}), 0);
  EXPECT_EQ(axis_evidence(plane, {normal(0), normal(20)}), 0);
  EXPECT_EQ(axis_evidence(plane, {normal(0), kAxis}), 0) << "a slice of the stack is no view";
  // One view of three lies elsewhere: of three pairs one meets.
  const double most = axis_evidence(plane, {normal(0), normal(90), Vec3(1, 1, 1).normalized()});
  EXPECT_GT(most, 0.2);
  EXPECT_LT(most, 0.8);
}

}  // namespace
}  // namespace beatlas::ingest::stack_rank_tests
