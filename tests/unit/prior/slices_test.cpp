#include "pipeline/prior/slices.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/prior/made_models.h"

namespace beatlas::prior {
namespace {

TEST(PriorSlices, TheLatticeHasTheMiddleOfTheStack) {
  const Grid stack = made::turned_grid({101, 67, 9}, {1.37, 0.83, 7.5});
  const Grid seen = network_grid(stack, 2, 16);
  EXPECT_EQ(seen.size, (Index3{69, 28, 9}));
  const Vec3 spacing = seen.spacing_mm();
  EXPECT_NEAR(spacing[0], 2, 1e-12);
  EXPECT_NEAR(spacing[1], 2, 1e-12);
  EXPECT_NEAR(spacing[2], 7.5, 1e-12);
  for (int k = 0; k < 9; ++k) {
    EXPECT_LT((seen.mm(34, 13.5, k) - stack.mm(50, 33, k)).norm(), 1e-9);
  }
  const Vec3 i_axis = seen.mm_from_index.linear().col(0).normalized();
  EXPECT_LT((i_axis - stack.mm_from_index.linear().col(0).normalized()).norm(), 1e-12);
}

TEST(PriorSlices, ARimIsLeftOutWhereAMultipleOfZerosWouldBeSeen) {
  const auto width = [](int size, double spacing_mm, int multiple) {
    return network_grid(made::turned_grid({size, 20, 1}, {spacing_mm, 2, 8}), 2, multiple).size[0];
  };
  EXPECT_EQ(width(256, 1.4, 16), 176);  // of 179
  EXPECT_EQ(width(256, 1.0, 16), 128);  // as it is
  EXPECT_EQ(width(181, 2.0, 16), 181);  // 5 of 16 are image
  EXPECT_EQ(width(180, 2.0, 16), 176);  // 4 mm at each edge
  EXPECT_EQ(width(133, 2.0, 64), 133);  // more than that
  EXPECT_EQ(width(3, 2.0, 16), 3);      // all that there is
  EXPECT_EQ(width(1, 0.5, 16), 1);
}

TEST(PriorSlices, PercentilesAreThoseOfAllPhasesOfTheSlice) {
  // 1000 values 0..999 in the slice of both phases, another slice beside it.
  ImageCycle<float> images;
  images.grid.size = {25, 20, 2};
  images.phases.assign(2, std::vector<float>(1000, 5e6F));
  for (int n = 0; n < 1000; ++n) {
    const int shuffled = n * 387 % 1000;
    images.phases[static_cast<std::size_t>(n % 2)][static_cast<std::size_t>(500 + n / 2)] =
        static_cast<float>(shuffled);
  }
  const Brightness found = brightness_of(images, 1);
  EXPECT_NEAR(found.low, 9.99, 1e-3);
  EXPECT_NEAR(found.high, 994.005, 1e-3);
  EXPECT_EQ(found.of(-3), 0);
  EXPECT_NEAR(found.of(9.99F + 0.25F * 984.015F), 0.5, 1e-5);
  EXPECT_NEAR(found.of(9.99F + 0.25F * 984.015F, 2), 0.0625, 1e-5);
  EXPECT_NEAR(found.of(1e6), std::sqrt(1.2), 1e-6);
  EXPECT_EQ(brightness_of(images, 0).of(5e6F), 0);  // of one value
  EXPECT_EQ(found.of(std::nanf("")), 0);
}

TEST(PriorSlices, ARampStaysWhereItIsInThePatient) {
  for (const double spacing_mm : {0.7, 1.0, 1.37, 2.0, 2.6, 4.0}) {
    const double factor = 2 / spacing_mm;
    const int source = 90;
    const int result = static_cast<int>(std::lround(source / factor));
    const AxisWeights axis = axis_weights(source, result, factor);
    const double edge_mm = (source * spacing_mm - result * 2) / 2;
    const int margin = 8;
    for (int o = margin; o < result - margin; ++o) {
      const auto at = static_cast<std::size_t>(o);
      double value = 0;  // of an image that holds each pixel's place from the image's edge [mm]
      double sum = 0;
      for (std::size_t n = 0; n < axis.weights[at].size(); ++n) {
        sum += axis.weights[at][n];
        value += axis.weights[at][n] * (axis.first[at] + static_cast<int>(n) + 0.5) * spacing_mm;
      }
      EXPECT_NEAR(sum, 1, 1e-6);
      EXPECT_NEAR(value, edge_mm + (o + 0.5) * 2, 1e-4) << spacing_mm << " " << o;
    }
  }
}

TEST(PriorSlices, ShrinkingIsAGaussianAndThenLinear) {
  // Straight from the definition, in two dimensions and in double.
  const Exam exam = made::rough_exam(made::turned_grid({31, 26, 1}, {1.2, 0.8, 8}), 1);
  const SeenSlices seen = see(exam.stack, ModelCard{}, {});
  const Brightness brightness = brightness_of(exam.stack.images, 0);
  const double fi = 2 / 1.2;
  const double fj = 2 / 0.8;
  const auto smooth = [&](int i, int j) {
    const double si = (fi - 1) / 2;
    const double sj = (fj - 1) / 2;
    const int ri = static_cast<int>(4 * si + 0.5);
    const int rj = static_cast<int>(4 * sj + 0.5);
    double sum = 0;
    double weights = 0;
    for (int b = -rj; b <= rj; ++b) {
      for (int a = -ri; a <= ri; ++a) {
        const double weight = std::exp(-0.5 * (a * a / (si * si) + b * b / (sj * sj)));
        const float value = exam.stack.images.phases[0][exam.stack.grid().offset(
            std::clamp(i + a, 0, 30), std::clamp(j + b, 0, 25), 0)];
        sum += weight * brightness.of(value);
        weights += weight;
      }
    }
    return sum / weights;
  };
  for (int b = 0; b < seen.grid.size[1]; ++b) {
    for (int a = 0; a < seen.grid.size[0]; ++a) {
      const Vec3 place = exam.stack.grid().mm_from_index.inverse() * seen.grid.mm(a, b, 0);
      const double x = std::clamp(place[0], 0.0, 30.0);
      const double y = std::clamp(place[1], 0.0, 25.0);
      const int i = std::min(static_cast<int>(x), 29);
      const int j = std::min(static_cast<int>(y), 24);
      const double u = x - i;
      const double v = y - j;
      const double wanted = (1 - v) * ((1 - u) * smooth(i, j) + u * smooth(i + 1, j)) +
                            v * ((1 - u) * smooth(i, j + 1) + u * smooth(i + 1, j + 1));
      EXPECT_NEAR(seen.frames[0][0][seen.grid.offset(a, b, 0)], wanted, 1e-5) << a << " " << b;
    }
  }
}

TEST(PriorSlices, NeighboursAreTheSlicesThatShowSomethingElse) {
  const auto none = std::optional<int>();
  // 8 mm wanted of slices 3 mm apart: three away.
  EXPECT_EQ(neighbour_of(10, -1, 20, 3, 8), 7);
  EXPECT_EQ(neighbour_of(10, +1, 20, 3, 8), 13);
  EXPECT_EQ(neighbour_of(2, -1, 20, 3, 8), 0);     // the last one there, 6 mm away
  EXPECT_EQ(neighbour_of(1, -1, 20, 3, 8), none);  // 3 mm away
  EXPECT_EQ(neighbour_of(0, -1, 20, 3, 8), none);
  EXPECT_EQ(neighbour_of(18, +1, 20, 3, 8), none);
  EXPECT_EQ(neighbour_of(4, +1, 20, 12, 8), 5);
  EXPECT_EQ(neighbour_of(4, +1, 20, 20, 8), 5);
  EXPECT_EQ(neighbour_of(4, +1, 20, 21, 8), none);
  EXPECT_EQ(neighbour_of(0, +1, 1, 8, 8), none);  // one slice
}

TEST(PriorSlices, TheDeviationIsFourTimesThatOfThePhases) {
  Exam exam = made::rough_exam(made::turned_grid({12, 10, 2}, {2, 2, 9}), 2);
  const SeenSlices seen = see(exam.stack, ModelCard{}, {});
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t v = 0; v < seen.grid.slice_count(); ++v) {
      const float first = seen.frames[k][0][v];
      const float second = seen.frames[k][1][v];
      EXPECT_NEAR(seen.means[k][v], (first + second) / 2, 1e-6);
      EXPECT_NEAR(seen.deviations[k][v], 2 * std::abs(first - second), 1e-5);
    }
  }
  exam.stack.images.phases.pop_back();
  const SeenSlices still = see(exam.stack, ModelCard{}, {});
  for (const float value : still.deviations[0]) EXPECT_EQ(value, 0);
}

}  // namespace
}  // namespace beatlas::prior
