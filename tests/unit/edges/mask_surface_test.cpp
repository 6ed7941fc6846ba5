/// Coverage from a mask alone, against closed form.
#include "pipeline/edges/mask_surface.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/edges/boundary.h"
#include "tests/made_images.h"

namespace beatlas::edges {
namespace {

using Mask = std::vector<std::uint8_t>;

constexpr int kParts = 6;  ///< of a voxel's edge, to count its share

/// What of each voxel is in a body, and the mask of those more than half in it.
struct Body {
  Grid grid;
  std::vector<float> share;
  Mask mask;

  Body(const Index3& size, const Vec3& spacing_mm, const std::function<bool(const Vec3&)>& inside)
      : grid(made::straight_grid(size, spacing_mm)), share(grid.count()), mask(grid.count()) {
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) {
          int count = 0;
          for (int n = 0; n < kParts * kParts * kParts; ++n) {
            const auto part = [](int at) { return (at % kParts + 0.5) / kParts - 0.5; };
            count +=
                inside(grid.mm(i + part(n), j + part(n / kParts), k + part(n / kParts / kParts)));
          }
          const std::size_t v = grid.offset(i, j, k);
          share[v] = static_cast<float>(count) / (kParts * kParts * kParts);
          mask[v] = share[v] > 0.5F;
        }
      }
    }
  }
};

/// Root of the mean square over the voxels that the body covers in part.
double rms_of_partial(const Body& body, const std::vector<float>& coverage) {
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < coverage.size(); ++v) {
    sum += std::pow(static_cast<double>(coverage[v] - body.share[v]), 2);
    count += body.share[v] > 0 && body.share[v] < 1;
  }
  return std::sqrt(sum / count);
}

double sum_of(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

bool in_ellipsoid(const Vec3& x, const Vec3& middle, const Vec3& axes) {
  return (x - middle).cwiseQuotient(axes).squaredNorm() < 1;
}

TEST(MaskSurface, OfAnEllipsoidIsItsShareOfTheVoxels) {
  for (const double slice_mm : {2.0, 3.0}) {
    const Vec3 middle(31.3, 30.8, 34.4);
    const Body body({64, 62, static_cast<int>(68 / slice_mm)}, {1, 1, slice_mm},
                    [&](const Vec3& x) { return in_ellipsoid(x, middle, Vec3(22, 17, 26)); });
    const std::vector<float> coverage = smooth_coverage(body.grid, body.mask);
    const double outline = rms_of_partial(body, outline_coverage(body.grid, body.mask));
    const double smooth = rms_of_partial(body, coverage);
    std::cout << slice_mm << " mm: rms " << smooth << ", of outlines " << outline << "\n";
    EXPECT_LT(smooth, 0.08);
    EXPECT_LT(smooth, 0.5 * outline);
    EXPECT_NEAR(sum_of(coverage) / sum_of(body.share), 1, 0.005);
  }
}

// Its edges are sharper than any smooth body's: there outlines count.
TEST(MaskSurface, OfABlockIsNoWorseThanItsOutlines) {
  const Body body({60, 60, 30}, {1, 1, 2}, [](const Vec3& x) {
    return (x - Vec3(30.2, 29.6, 29.9)).cwiseAbs().cwiseQuotient(Vec3(15, 12, 14)).maxCoeff() < 1;
  });
  const std::vector<float> coverage = smooth_coverage(body.grid, body.mask);
  const std::vector<float> outline = outline_coverage(body.grid, body.mask);
  EXPECT_LT(rms_of_partial(body, coverage), 1.05 * rms_of_partial(body, outline));
  const auto off = [&](const std::vector<float>& found) {
    return std::abs(sum_of(found) / sum_of(body.share) - 1);
  };
  EXPECT_LT(off(coverage), off(outline) + 0.005);
}

TEST(MaskSurface, OfAWallOfOneVoxelStaysAWall) {
  const Body body({40, 40, 20}, {1, 1, 2}, [](const Vec3& x) {
    return std::abs(x[0] - 20) < 0.6 && std::abs(x[1] - 20) < 12 && std::abs(x[2] - 19) < 12;
  });
  const double wall = sum_of(outline_coverage(body.grid, body.mask));
  EXPECT_GT(wall, 0);
  EXPECT_GT(sum_of(smooth_coverage(body.grid, body.mask)), 0.95 * wall);
}

TEST(MaskSurface, GoesOnWhereTheGridCutsIt) {
  const Body body({30, 60, 30}, {1, 1, 2}, [](const Vec3& x) {
    return std::hypot(x[1] - 30.3, x[2] - 29.2) < 18;  // a cylinder through both sides
  });
  const std::vector<float> coverage = smooth_coverage(body.grid, body.mask);
  EXPECT_LT(rms_of_partial(body, coverage),
            0.4 * rms_of_partial(body, outline_coverage(body.grid, body.mask)));
  for (std::size_t v = 0; v < coverage.size(); ++v) {
    EXPECT_NEAR(coverage[v], coverage[v - v % 30 + 15], 1e-3) << v;  // at the cut as in the middle
  }
}

TEST(MaskSurface, OfNothingIsNothingAndOfAllIsAll) {
  for (const Index3& size : {Index3{20, 18, 9}, Index3{20, 18, 1}, Index3{1, 1, 1}}) {
    const Grid grid = made::straight_grid(size, {1.4, 1.4, 3});
    for (const std::uint8_t value : {0, 1}) {
      for (const float share : smooth_coverage(grid, Mask(grid.count(), value))) {
        EXPECT_EQ(share, value);
      }
    }
  }
}

TEST(MaskSurface, OfAnyMaskIsAShare) {
  const Grid grid = made::straight_grid({24, 20, 9}, {1.4, 1.4, 2});
  for (unsigned draw = 0; draw < 4; ++draw) {
    std::mt19937 random(draw);
    Mask mask(grid.count());
    for (std::uint8_t& value : mask) value = random() % 3 == 0;
    for (const float share : smooth_coverage(grid, mask)) {
      ASSERT_TRUE(share >= 0 && share <= 1) << share;
    }
  }
}

}  // namespace
}  // namespace beatlas::edges
