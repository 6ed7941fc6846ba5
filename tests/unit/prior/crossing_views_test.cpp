/// What views tell of the slices that they cross, on made priors of a ventricle in closed form: a
/// cavity of 16 mm about the axis of the slices in a wall of 8 mm, whose blood is told by letters.
#include "pipeline/prior/crossing_views.h"

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/prior/stored.h"
#include "runtime/atlas/structures.h"

namespace beatlas::prior {
namespace {

constexpr int kSlices = 6;
constexpr double kDistanceMm = 10;
constexpr int kPixels = 48;
constexpr double kPixelMm = 2;
constexpr int kPhases = 3;
constexpr double kSure = 0.93;                     ///< of the label that is told
constexpr std::array<double, 2> kTurns{0.3, 1.8};  ///< [rad] of the views about the axis

using Teller = std::function<std::uint8_t(const Vec3& mm)>;

/// Label at a place of a ventricle along z whose blood is `blood`.
std::uint8_t ventricle(const Vec3& mm, std::uint8_t blood = kLabelLvBlood) {
  const double r = std::hypot(mm.x(), mm.y());
  if (r < 16) return blood;
  return r < 24 ? kLabelLvMyocardium : kLabelBackground;
}

PriorCycle made(const Grid& grid, const Teller& label) {
  PriorCycle out;
  out.grid = grid;
  out.labels = {kLabelBackground,  kLabelRvBlood, kLabelLvMyocardium, kLabelLvBlood,
                kLabelRestOfHeart, kLabelLaBlood, kLabelRaBlood,      kLabelAorta};
  const std::size_t count = grid.count();
  const auto less =
      stored_log(static_cast<float>((1 - kSure) / static_cast<double>(out.labels.size() - 1)));
  out.phases.assign(kPhases, std::vector<std::int8_t>(out.labels.size() * count, less));
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        for (std::vector<std::int8_t>& phase : out.phases) {
          phase[label(grid.mm(i, j, k)) * count + grid.offset(i, j, k)] =
              stored_log(static_cast<float>(kSure));
        }
      }
    }
  }
  return out;
}

Grid stack_grid() {
  Grid out;
  out.size = {kPixels, kPixels, kSlices};
  out.mm_from_index.linear() = Vec3(kPixelMm, kPixelMm, kDistanceMm).asDiagonal();
  out.mm_from_index.translation() = Vec3(-47, -47, 0);
  return out;
}

/// Through the axis, in the direction of `turn` [rad], and `along_mm` up and down it.
Grid view_grid(double turn, double off_mm = 0) {
  const Vec3 across(std::cos(turn), std::sin(turn), 0);
  const Vec3 normal = across.cross(Vec3::UnitZ());
  Grid out;
  out.size = {kPixels, kPixels, 1};
  out.mm_from_index.linear() << kPixelMm * across, kPixelMm * Vec3::UnitZ(), 8 * normal;
  out.mm_from_index.translation() = -47 * across + Vec3(0, 0, -20) + off_mm * normal;
  return out;
}

std::vector<PriorCycle> two_views(const Teller& label) {
  return {made(view_grid(kTurns[0]), label), made(view_grid(kTurns[1]), label)};
}

/// Voxels of a slice, of the places that count, whose likeliest label is not the one that is told,
/// in any phase.
int wrong_in(
    const PriorCycle& stack, int k, const Teller& label,
    const std::function<bool(const Vec3& mm)>& counts = [](const Vec3&) { return true; }) {
  int out = 0;
  for (std::size_t p = 0; p < stack.phases.size(); ++p) {
    for (int j = 0; j < kPixels; ++j) {
      for (int i = 0; i < kPixels; ++i) {
        const Vec3 mm = stack.grid.mm(i, j, k);
        if (!counts(mm)) continue;
        if (stack.likeliest(p, stack.grid.offset(i, j, k)) != label(mm)) ++out;
      }
    }
  }
  return out;
}

const Teller kTruth = [](const Vec3& mm) { return ventricle(mm); };

TEST(CrossingViews, MendASliceThatTakesAnApexForTheRightVentricle) {
  PriorCycle stack = made(stack_grid(), [](const Vec3& mm) -> std::uint8_t {
    if (mm.z() > 5) return ventricle(mm);
    return ventricle(mm) == kLabelLvBlood ? kLabelRvBlood : kLabelBackground;
  });
  // Of the cavity what lies beside a view; the rest grows from there.
  const auto beside_views = [](const Vec3& mm) {
    const auto from = [&](double turn) {
      return std::abs(mm.x() * std::sin(turn) - mm.y() * std::cos(turn));
    };
    return std::min(from(kTurns[0]), from(kTurns[1])) < 4 && std::hypot(mm.x(), mm.y()) < 12;
  };
  ASSERT_GT(wrong_in(stack, 0, kTruth, beside_views), 150);
  const auto [views, unknown] = heed_views(two_views(kTruth), stack);
  EXPECT_EQ(views, 2);
  ASSERT_EQ(unknown.size(), static_cast<std::size_t>(kSlices));
  EXPECT_GT(unknown[0], 0.5);
  EXPECT_EQ(wrong_in(stack, 0, kTruth, beside_views), 0);
  for (int k = 1; k < kSlices; ++k) {
    EXPECT_LT(unknown[static_cast<std::size_t>(k)], 0.01) << k;
    EXPECT_EQ(wrong_in(stack, k, kTruth), 0) << k;
  }
}

TEST(CrossingViews, LeaveEdgesToSlicesThatABreathHoldMoved) {
  const auto moved = [](const Vec3& mm) { return ventricle(mm - Vec3(4, 0, 0)); };
  PriorCycle stack = made(stack_grid(), moved);
  (void)heed_views(two_views(kTruth), stack);
  int wall = 0;
  for (int k = 0; k < kSlices; ++k) wall += wrong_in(stack, k, moved);
  const int all = kPhases * kSlices * static_cast<int>(3.14159 * 24 * 24 / (kPixelMm * kPixelMm));
  EXPECT_LT(wall, all / 100);
}

TEST(CrossingViews, LeaveToSlicesWhereVentriclesEndAndAtriaBegin) {
  const auto with_atrium = [](const Vec3& mm) {
    return ventricle(mm, mm.z() > 35 ? kLabelLaBlood : kLabelLvBlood);
  };
  PriorCycle stack = made(stack_grid(), with_atrium);
  (void)heed_views(two_views(kTruth), stack);
  for (int k = 0; k < kSlices; ++k) EXPECT_EQ(wrong_in(stack, k, with_atrium), 0) << k;
}

TEST(CrossingViews, TellNothingWhereTheNetworkSeesNothingInThem) {
  const PriorCycle before = made(stack_grid(), kTruth);
  PriorCycle stack = before;
  const auto blank = made(view_grid(kTurns[0]), [](const Vec3&) { return kLabelBackground; });
  EXPECT_EQ(heed_views({blank}, stack).views, 0);
  EXPECT_EQ(stack.phases, before.phases);
  EXPECT_EQ(heed_views({blank, made(view_grid(kTurns[1]), kTruth)}, stack).views, 1);
}

TEST(CrossingViews, TellNothingOfSlicesThatTheyDoNotCross) {
  const PriorCycle before = made(stack_grid(), kTruth);
  PriorCycle stack = before;
  Grid along = stack_grid();
  along.size[2] = 1;
  EXPECT_FALSE(crosses(along, stack.grid));
  EXPECT_TRUE(crosses(view_grid(kTurns[0]), stack.grid));
  const auto told = heed_views({made(along, [](const Vec3&) { return kLabelRvBlood; })}, stack);
  EXPECT_EQ(told.views, 0);
  EXPECT_EQ(told.unknown, std::vector<double>(kSlices, 0));
  EXPECT_EQ(heed_views({}, stack).unknown, std::vector<double>(kSlices, 0));
  EXPECT_EQ(stack.phases, before.phases);
}

}  // namespace
}  // namespace beatlas::prior
