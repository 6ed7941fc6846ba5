/// What is thick does not hang on the last bit of a file's geometry.
#include "pipeline/core/slices.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "pipeline/core/grid.h"

namespace beatlas {
namespace {

TEST(ThickSlices, OfFiveMillimetresAreThickHoweverTheyLie) {
  for (int n = 0; n < 100; ++n) {
    Grid grid;
    // As a NIfTI file has it: columns of a rotation, in single precision.
    const Eigen::AngleAxisf turn(0.06F * static_cast<float>(n),
                                 Eigen::Vector3f(1, 2, 3).normalized());
    const Eigen::Matrix3f columns =
        turn.toRotationMatrix() * Eigen::Vector3f(1.25F, 1.25F, 5).asDiagonal();
    grid.mm_from_index.linear() = columns.cast<double>();
    EXPECT_TRUE(are_thick_slices(grid.spacing_mm()[2])) << n << ' ' << grid.spacing_mm()[2] - 5;
  }
  EXPECT_FALSE(are_thick_slices(4.95));
  EXPECT_FALSE(are_thick_slices(3));
}

}  // namespace
}  // namespace beatlas
