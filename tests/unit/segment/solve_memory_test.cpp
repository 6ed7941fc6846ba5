/// A solve that begins from what another left gives what a solve of its own gives, bit by bit.
#include <functional>

#include <gtest/gtest.h>

#include "pipeline/segment/groundwork.h"
#include "pipeline/segment/segment.h"
#include "tests/unit/segment/imaged_phantom.h"
#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

constexpr int kPhases = 6;

const Exam& exam() {
  static const Exam made = [] {
    phantom::PhantomSpec spec = phantom::preset("small");
    spec.phases = kPhases;
    return made::ImagedPhantom(spec).exam;
  }();
  return made;
}

struct Solved {
  Segmentation result;
  bool from_memory = false;  ///< the chambers were not looked for
};

Solved solve(const std::vector<Seed>& seeds, SolveMemory* memory) {
  Solved out;
  out.from_memory = true;
  StageContext context;
  context.log_sink = [&](std::string_view line) {
    if (line.find("left ventricle in slices") != std::string_view::npos) out.from_memory = false;
  };
  out.result = segment_exam(exam(), seeds, {}, context, {}, memory);
  return out;
}

/// What the first solve, with automatic seeds, left.
const SolveMemory& first_memory() {
  static const SolveMemory made = [] {
    SolveMemory memory;
    (void)solve({}, &memory);
    return memory;
  }();
  return made;
}

const Segmentation& automatic() {
  static const Segmentation made = solve({}, nullptr).result;
  return made;
}

/// A voxel of `label` in the slice and phase, the farthest towards greater i.
Vec3 outermost(std::uint8_t label, int phase, int k) {
  const Grid& grid = exam().stack.grid();
  const std::vector<std::uint8_t>& labels =
      automatic().labels.phases[static_cast<std::size_t>(phase)];
  for (int i = grid.size[0] - 1; i >= 0; --i) {
    for (int j = 0; j < grid.size[1]; ++j) {
      if (labels[grid.offset(i, j, k)] == label) return {double(i), double(j), double(k)};
    }
  }
  ADD_FAILURE() << "no voxel of label " << int(label) << " in slice " << k;
  return Vec3::Zero();
}

int middle_slice() { return exam().stack.grid().size[2] / 2; }

/// A stroke of background across the outer wall, in one phase.
Seed cutting_stroke() {
  const Grid& grid = exam().stack.grid();
  const Vec3 at = outermost(kLabelLvMyocardium, 2, middle_slice());
  Seed seed;
  seed.label = kLabelBackground;
  seed.phase = 2;
  seed.radius_mm = 3;
  seed.lps_mm = grid.mm_from_index * Vec3(at - Vec3(0, 4, 0));
  seed.stroke_lps_mm = {grid.mm_from_index * Vec3(at + Vec3(0, 4, 0))};
  return seed;
}

Seed muscle_ball() {
  Seed seed;
  seed.label = kLabelLvMyocardium;
  seed.phase = 4;
  seed.lps_mm = exam().stack.grid().mm_from_index * outermost(kLabelRvBlood, 4, middle_slice());
  return seed;
}

void expect_same(const Segmentation& a, const Segmentation& b) {
  EXPECT_EQ(a.labels.phases, b.labels.phases);
  EXPECT_EQ(a.coverage.first, b.coverage.first);
  EXPECT_EQ(a.coverage.phases, b.coverage.phases);
  EXPECT_EQ(a.end_diastole, b.end_diastole);
  EXPECT_EQ(a.end_systole, b.end_systole);
  EXPECT_EQ(a.warnings, b.warnings);
  ASSERT_EQ(a.base_cuts.size(), b.base_cuts.size());
  for (const auto& [structure, cut] : a.base_cuts) {
    EXPECT_EQ(cut.base_step, b.base_cuts.at(structure).base_step);
    EXPECT_EQ(cut.k, b.base_cuts.at(structure).k);
  }
}

TEST(SolveMemory, a_stroke_is_solved_from_it_as_without_it) {
  SolveMemory memory = first_memory();
  const std::vector<Seed> seeds{cutting_stroke()};
  const Solved again = solve(seeds, &memory);
  EXPECT_TRUE(again.from_memory);
  const Segmentation whole = solve(seeds, nullptr).result;
  expect_same(again.result, whole);
  EXPECT_NE(whole.labels.phases, automatic().labels.phases) << "the stroke changed nothing";

  // Another stroke, then the first one taken back.
  const std::vector<Seed> more{cutting_stroke(), muscle_ball()};
  const Solved third = solve(more, &memory);
  EXPECT_TRUE(third.from_memory);
  expect_same(third.result, solve(more, nullptr).result);
  const Solved back = solve({}, &memory);
  EXPECT_TRUE(back.from_memory);
  expect_same(back.result, automatic());
}

TEST(SolveMemory, what_a_solve_leaves_is_the_same_with_and_without_memory_before) {
  SolveMemory with = first_memory();
  (void)solve({muscle_ball()}, &with);
  SolveMemory without;
  (void)solve({muscle_ball()}, &without);
  EXPECT_EQ(with.numbers, without.numbers);
  ASSERT_EQ(with.images.size(), without.images.size());
  for (const auto& [name, images] : with.images) {
    EXPECT_EQ(images.phases, without.images.at(name).phases) << name;
  }
}

TEST(SolveMemory, is_left_aside_for_seeds_it_does_not_hold_for) {
  // Blood of the LV beyond the slices that show one: the chambers themselves change.
  const Grid& grid = exam().stack.grid();
  const Segmentation& found = automatic();
  Index3 far{grid.size[0] / 2, grid.size[1] / 2, 0};
  Seed seed;
  seed.label = kLabelLvBlood;
  seed.phase = found.end_diastole;
  seed.lps_mm = grid.mm(far[0], far[1], far[2]);
  SolveMemory memory = first_memory();
  const Solved again = solve({seed}, &memory);
  EXPECT_FALSE(again.from_memory);
  expect_same(again.result, solve({seed}, nullptr).result);
}

TEST(SolveMemory, that_is_spoiled_is_left_aside) {
  const auto holds = [](SolveMemory memory) {
    return recall(std::move(memory), exam().stack.grid(), kPhases, {cutting_stroke()}).has_value();
  };
  EXPECT_TRUE(holds(first_memory()));
  EXPECT_FALSE(holds({}));
  const auto spoiled = [](const std::function<void(SolveMemory&)>& spoil) {
    SolveMemory memory = first_memory();
    spoil(memory);
    return memory;
  };
  for (const auto& list : first_memory().numbers) {
    const std::string& name = list.first;
    // Without its axis, or the slices across it, it would be that of a stack of thick slices.
    if (!list.second.empty() && name != "axis" && !name.starts_with("looked_1")) {
      EXPECT_FALSE(holds(spoiled([&](SolveMemory& m) { m.numbers.erase(name); }))) << name;
    }
    EXPECT_FALSE(holds(spoiled([&](SolveMemory& m) { m.numbers.at(name).push_back(0); }))) << name;
  }
  for (const auto& image : first_memory().images) {
    const std::string& name = image.first;
    EXPECT_FALSE(holds(spoiled([&](SolveMemory& m) { m.images.erase(name); }))) << name;
    EXPECT_FALSE(holds(spoiled([&](SolveMemory& m) { m.images.at(name).phases.pop_back(); })))
        << name;
    if (name == "masks") continue;
    EXPECT_FALSE(holds(spoiled([&](SolveMemory& m) { m.images.at(name).phases[0][0] = 9; })))
        << name;
  }
  EXPECT_FALSE(holds(spoiled([](SolveMemory& m) { m.numbers.at("boxes").at(3) = 1e9; })));
  EXPECT_FALSE(holds(spoiled([](SolveMemory& m) { m.numbers.at("slices").at(0) = -1; })));
}

}  // namespace
}  // namespace beatlas::segment
