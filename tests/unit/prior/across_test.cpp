/// Stacks cut anew across an LV that lies along their slices.
#include "pipeline/prior/across.h"

#include <cmath>

#include <gtest/gtest.h>

#include "runtime/atlas/structures.h"

namespace beatlas::prior {
namespace {

Grid grid_of(const Index3& size, const Vec3& mm) {
  Grid out;
  out.size = size;
  out.mm_from_index = Affine::Identity();
  out.mm_from_index.linear() = mm.asDiagonal();
  return out;
}

ModelCard card() {
  ModelCard out;
  out.outputs = {kLabelBackground, kLabelLvBlood, kLabelLvMyocardium};
  return out;
}

/// A spindle 90 mm long and 40 mm wide about the middle, along a direction.
PriorCycle seen(const Grid& grid, const Vec3& along) {
  PriorCycle out{grid, card().outputs, {}};
  out.phases.assign(1, std::vector<std::int8_t>(3 * grid.count(), -128));
  const Vec3 middle = grid.mm(grid.size[0] / 2.0, grid.size[1] / 2.0, grid.size[2] / 2.0);
  std::size_t v = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++v) {
        const Vec3 off = grid.mm(i, j, k) - middle;
        const double length = off.dot(along) / 45;
        const double width = (off - along * off.dot(along)).norm() / 20;
        const double r = std::hypot(length, width);
        const std::size_t output = r < 0.6 ? 1 : r < 1 ? 2 : 0;
        out.phases[0][output * grid.count() + v] = 0;
      }
    }
  }
  return out;
}

const Grid kStack = grid_of({64, 64, 40}, {2, 2, 3});

TEST(AcrossLv, LooksAlongAnLvThatLiesInTheSlices) {
  const Vec3 along = Vec3(1, 1, 0.3).normalized();
  const auto found = across_lv(seen(kStack, along), kStack, card());
  ASSERT_TRUE(found);
  const Eigen::Matrix3d axes = found->grid.mm_from_index.linear().colwise().normalized();
  EXPECT_GT(std::abs(axes.col(2).dot(along)), std::cos(3 * M_PI / 180));
  EXPECT_GT(axes.determinant(), 0.999) << "right-handed, at right angles";
  const Vec3 spacing = found->grid.spacing_mm();
  EXPECT_NEAR(spacing[0], 2, 1e-9);
  EXPECT_NEAR(spacing[2], 4, 1e-9);
  // The window holds the spindle with room on all sides.
  const Grid seen_grid = network_grid(found->grid, 2, 16);
  const Grid part = seen_grid.part(found->window.first, found->window.size);
  const Affine index = part.mm_from_index.inverse(Eigen::Affine);
  const Vec3 middle = kStack.mm(32, 32, 20);
  for (const double end : {-45.0, 45.0}) {
    const Vec3 at = index * (middle + end * along);
    for (int a = 0; a < 3; ++a) {
      EXPECT_GT(at[a], 2) << a;
      EXPECT_LT(at[a], part.size[static_cast<std::size_t>(a)] - 3) << a;
    }
  }
}

TEST(AcrossLv, LeavesSlicesThatAreThickOrLieAcrossAsTheyAre) {
  EXPECT_FALSE(across_lv(seen(kStack, Vec3(0.3, 0, 1).normalized()), kStack, card()));
  const Grid thick = grid_of({64, 64, 12}, {2, 2, 8});
  EXPECT_FALSE(across_lv(seen(thick, Vec3::UnitX()), thick, card()));
  PriorCycle nothing = seen(kStack, Vec3::UnitX());
  nothing.phases[0].clear();
  EXPECT_FALSE(across_lv(nothing, kStack, card()));
}

TEST(AcrossLv, CuttingAnewKeepsWhatIsLinearInSpace) {
  Cine stack;
  stack.images.grid = kStack;
  stack.images.phases.assign(2, std::vector<float>(kStack.count()));
  const auto value = [](const Vec3& mm) { return 100 + mm.dot(Vec3(1, -0.5, 2)); };
  for (int k = 0; k < 40; ++k) {
    for (int j = 0; j < 64; ++j) {
      for (int i = 0; i < 64; ++i) {
        for (auto& phase : stack.images.phases) {
          phase[kStack.offset(i, j, k)] = static_cast<float>(value(kStack.mm(i, j, k)));
        }
      }
    }
  }
  const auto found = across_lv(seen(kStack, Vec3(1, 0.2, 0.1).normalized()), kStack, card());
  ASSERT_TRUE(found);
  const Grid& grid = found->grid;
  const Cine anew = cut_anew(stack, grid);
  ASSERT_EQ(anew.phase_count(), 2);
  const Affine index = kStack.mm_from_index.inverse(Eigen::Affine);
  int inside = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; j += 7) {
      for (int i = 0; i < grid.size[0]; i += 7) {
        const Vec3 at = index * grid.mm(i, j, k);
        const float got = anew.images.phases[1][grid.offset(i, j, k)];
        if ((at.array() < -1e-6).any() || at[0] > 63 || at[1] > 63 || at[2] > 39) {
          EXPECT_EQ(got, 0);
        } else if ((at.array() > 1e-6).all()) {
          EXPECT_NEAR(got, value(grid.mm(i, j, k)), 1e-2);
          ++inside;
        }
      }
    }
  }
  EXPECT_GT(inside, 500);
}

TEST(AcrossLv, BothViewsCountAlikeAndWhatOneDidNotLookAtStays) {
  const Vec3 along = Vec3::UnitX();
  PriorCycle native = seen(kStack, along);
  const PriorCycle before = native;
  const auto found = across_lv(native, kStack, card());
  ASSERT_TRUE(found);
  // The other view takes everything for background.
  const Grid lattice = network_grid(found->grid, 2, 16);
  PriorCycle other{lattice, card().outputs, {}};
  other.phases.assign(1, std::vector<std::int8_t>(3 * lattice.count(), -128));
  std::fill_n(other.phases[0].begin(), lattice.count(), std::int8_t{0});
  mix_in(other, found->window, native);
  const std::size_t middle = kStack.offset(32, 32, 20);
  const auto likely = [&](const PriorCycle& prior, std::size_t output, std::size_t v) {
    return std::exp(prior.phases[0][output * kStack.count() + v] / double{PriorCycle::kUnits});
  };
  EXPECT_NEAR(likely(native, 1, middle), 0.5, 0.02);
  EXPECT_NEAR(likely(native, 0, middle), 0.5, 0.02);
  // A corner of the stack lies beyond the window.
  const std::size_t corner = kStack.offset(0, 0, 0);
  for (std::size_t o = 0; o < 3; ++o) {
    EXPECT_EQ(native.phases[0][o * kStack.count() + corner],
              before.phases[0][o * kStack.count() + corner]);
  }
}

}  // namespace
}  // namespace beatlas::prior
