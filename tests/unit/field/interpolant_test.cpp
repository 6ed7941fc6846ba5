#include "pipeline/field/interpolant.h"

#include <gtest/gtest.h>

#include "tests/unit/field/closed_form.h"

namespace beatlas::field {
namespace {

double quadratic(const Vec3& x) {
  return 0.3 + 0.5 * x.x() - 0.2 * x.y() + 0.1 * x.z() + 0.02 * x.x() * x.x() -
         0.03 * x.y() * x.z() + 0.01 * x.z() * x.z();
}

Vec3 quadratic_slope(const Vec3& x) {
  return {0.5 + 0.04 * x.x(), -0.2 - 0.03 * x.z(), 0.1 - 0.03 * x.y() + 0.02 * x.z()};
}

TEST(Interpolant, ReproducesQuadraticsAndTheirGradient) {
  Grid grid = closed_form::lattice({-5, -6, -7}, {5, 6, 7}, 1.5);
  grid.mm_from_index.linear() =
      grid.mm_from_index.linear() *
      Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const std::vector<float> samples = closed_form::sampled(grid, quadratic);
  const Interpolant interpolant(grid, samples);
  for (double u : {2.0, 2.3, 3.99}) {
    const Vec3 x = grid.mm(u, 1.7 + u / 3, 2.1);
    const Interpolant::Sample got = interpolant.sample(x);
    EXPECT_NEAR(got.value, quadratic(x), 1e-5);  // samples are float
    EXPECT_LT((got.gradient - quadratic_slope(x)).norm(), 1e-5);
    EXPECT_DOUBLE_EQ(interpolant.value(x), got.value);
  }
}

TEST(Interpolant, WalksToTheZeroOfADistance) {
  const Grid grid = closed_form::lattice({-20, -20, -20}, {20, 20, 20}, 1.5);
  const std::vector<float> samples =
      closed_form::sampled(grid, [](const Vec3& x) { return x.norm() - 12.0; });
  const Interpolant interpolant(grid, samples);
  const Vec3 found = interpolant.project_to_zero({5, 7, -3}, 1.0);
  EXPECT_LT(std::abs(interpolant.value(found)), 1e-4);
  EXPECT_NEAR(found.norm(), 12.0, 0.002);  // error of cubic convolution at 12 mm radius
}

TEST(Interpolant, GoesOnAsItsBorderBeyondTheLattice) {
  const Grid grid = closed_form::lattice({0, 0, 0}, {4, 4, 4}, 1.0);
  const std::vector<float> samples(grid.count(), 2.5F);
  const Interpolant interpolant(grid, samples);
  EXPECT_DOUBLE_EQ(interpolant.value({-100, 50, 2}), 2.5);
  EXPECT_LT(interpolant.sample({-100, 50, 2}).gradient.norm(), 1e-12);
}

}  // namespace
}  // namespace beatlas::field
