#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/prior/prior.h"
#include "pipeline/prior/slices.h"
#include "tests/unit/prior/made_models.h"

namespace beatlas::prior {
namespace {

/// Of two outputs on the lattice of a stack, with log-probabilities that follow no pattern.
PriorCycle rough_prior(const Grid& stack) {
  PriorCycle out;
  out.grid = network_grid(stack, 2, 1);
  out.labels = {0, 3};
  std::vector<std::int8_t>& phase = out.phases.emplace_back(2 * out.grid.count());
  std::uint32_t state = 99;
  for (std::size_t v = 0; v < out.grid.count(); ++v) {
    state = state * 1664525U + 1013904223U;
    const double share = 0.02 + 0.96 * (state >> 8U) / 16777216.0;
    phase[v] = static_cast<std::int8_t>(std::lround(16 * std::log(share)));
    phase[out.grid.count() + v] = static_cast<std::int8_t>(std::lround(16 * std::log(1 - share)));
  }
  return out;
}

double stored(const PriorCycle& prior, std::size_t output, int i, int j, int k) {
  return std::exp(prior.phases[0][output * prior.grid.count() + prior.grid.offset(i, j, k)] / 16.0);
}

TEST(PriorProbabilities, OnItsOwnLatticeAreThoseStored) {
  const Grid stack = made::turned_grid({20, 15, 3}, {2, 2, 8});
  const PriorCycle prior = rough_prior(stack);
  const auto found = probabilities_on(prior, 0, stack);
  ASSERT_EQ(found.size(), 2U);
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 15; ++j) {
      for (int i = 0; i < 20; ++i) {
        const double first = stored(prior, 0, i, j, k);
        const double second = stored(prior, 1, i, j, k);
        EXPECT_NEAR(found[0][stack.offset(i, j, k)], first / (first + second), 1e-6);
        EXPECT_NEAR(found[1][stack.offset(i, j, k)], second / (first + second), 1e-6);
      }
    }
  }
}

TEST(PriorProbabilities, AreLinearInPlaneAtTheVoxelsOwnPlace) {
  const Grid stack = made::turned_grid({31, 45, 5}, {1.3, 0.9, 8});
  const PriorCycle prior = rough_prior(stack);
  const Grid part = stack.part({4, 7, 2}, {20, 30, 3});
  const auto found = probabilities_on(prior, 0, part);
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 30; ++j) {
      for (int i = 0; i < 20; ++i) {
        const Vec3 place = prior.grid.mm_from_index.inverse() * part.mm(i, j, k);
        const int a = static_cast<int>(place[0]);
        const int b = static_cast<int>(place[1]);
        const double u = place[0] - a;
        const double v = place[1] - b;
        ASSERT_NEAR(place[2], k + 2, 1e-9);
        std::vector<double> wanted;
        for (const std::size_t o : {std::size_t{0}, std::size_t{1}}) {
          wanted.push_back((1 - v) * ((1 - u) * stored(prior, o, a, b, k + 2) +
                                      u * stored(prior, o, a + 1, b, k + 2)) +
                           v * ((1 - u) * stored(prior, o, a, b + 1, k + 2) +
                                u * stored(prior, o, a + 1, b + 1, k + 2)));
        }
        const std::size_t at = part.offset(i, j, k);
        EXPECT_NEAR(found[0][at], wanted[0] / (wanted[0] + wanted[1]), 1e-5);
        EXPECT_NEAR(found[0][at] + found[1][at], 1, 1e-6);
      }
    }
  }
}

TEST(PriorProbabilities, GoOnToTheEdgeOfTheStack) {
  const Grid stack = made::turned_grid({31, 45, 2}, {1.3, 0.9, 8});
  const PriorCycle prior = rough_prior(stack);
  const auto found = probabilities_on(prior, 0, stack);
  for (const auto& [i, j] : {std::pair{0, 0}, std::pair{30, 44}}) {
    const int a = i == 0 ? 0 : prior.grid.size[0] - 1;
    const int b = j == 0 ? 0 : prior.grid.size[1] - 1;
    const double first = stored(prior, 0, a, b, 1);
    const double second = stored(prior, 1, a, b, 1);
    EXPECT_NEAR(found[0][stack.offset(i, j, 1)], first / (first + second), 0.02);
  }
}

TEST(PriorProbabilities, OfOtherVoxelsAreRefused) {
  const Grid stack = made::turned_grid({20, 15, 3}, {2, 2, 8});
  const PriorCycle prior = rough_prior(stack);
  const auto refused = [&](const Grid& part) {
    EXPECT_TRUE(made::tells(made::refusal([&] { (void)probabilities_on(prior, 0, part); }),
                            "another stack"));
  };
  refused(stack.part({0, 0, 1}, {20, 15, 3}));  // beyond the last slice
  Grid between = stack;
  between.mm_from_index.translation() = stack.mm(0, 0, 0.4);
  refused(between);
  Grid upright;
  upright.size = {4, 4, 1};
  refused(upright);
  EXPECT_TRUE(
      made::tells(made::refusal([&] { (void)probabilities_on(prior, 1, stack); }), "no phase 1"));
}

}  // namespace
}  // namespace beatlas::prior
