#include "pipeline/phantom/true_coverage.h"

#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"

namespace beatlas::phantom {
namespace {

PhantomSpec quick(const std::string& preset) {
  PhantomSpec spec = phantom::preset(preset);
  spec.phases = 2;
  return spec;
}

TEST(PhantomCoverage, AddsUpToTheVolumesInClosedForm) {
  const Phantom phantom(quick("small"));
  StageContext context;
  const CoverageCycle made = true_coverage(phantom, context);
  EXPECT_EQ(made.phases.size(), kAllStructures.size());
  for (const auto& [structure, phases] : made.phases) {
    ASSERT_EQ(phases.size(), 2U);
    for (int p = 0; p < 2; ++p) {
      const std::vector<float>& shares = phases[static_cast<std::size_t>(p)];
      const double ml = std::accumulate(shares.begin(), shares.end(), 0.0) * made.grid.voxel_ml();
      const double truth = phantom.volume_ml(structure, phantom.phase_time_s(p));
      // Creases, counted to 0.02 of a voxel without bias, and flat pieces of 1.5 mm.
      EXPECT_NEAR(ml, truth, 0.001 * truth) << structure_name(structure) << " " << p;
    }
  }
}

TEST(PhantomCoverage, IsTheShareOfPointsInside) {
  const Phantom phantom(quick("clinical"));
  StageContext context;
  const CoverageCycle made = true_coverage(phantom, context);
  const auto frame = phantom.frame(phantom.phase_time_s(1));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(-0.5, 0.5);
  for (const Structure structure : {Structure::Heart, Structure::LvMyocardium}) {
    const std::vector<float>& shares = made.phases.at(structure)[1];
    int mixed = 0;
    std::size_t v = 0;
    for (int k = 0; k < made.grid.size[2]; ++k) {
      for (int j = 0; j < made.grid.size[1]; ++j) {
        for (int i = 0; i < made.grid.size[0]; ++i, ++v) {
          const double share = shares[v];
          if (!(share > 0 && share < 1) || v % 29 != 0) continue;
          ++mixed;
          constexpr int kPoints = 1000;
          int inside = 0;
          for (int n = 0; n < kPoints; ++n) {
            const double x = i + within(random);
            const double y = j + within(random);
            const double z = k + within(random);
            inside += frame->contains(structure, made.grid.mm(x, y, z)) ? 1 : 0;
          }
          // Five standard deviations of the count, and what a crease is counted to.
          EXPECT_NEAR(share, static_cast<double>(inside) / kPoints,
                      5 * std::sqrt(0.25 / kPoints) + 0.02)
              << structure_name(structure) << " at " << i << " " << j << " " << k;
        }
      }
    }
    EXPECT_GT(mixed, 30) << structure_name(structure);
  }
}

TEST(PhantomCoverage, IsThatOfTheLabelsAndHoldsAllOfThem) {
  const Phantom phantom(quick("small"));
  StageContext context;
  const CoverageCycle made = true_coverage(phantom, context);
  const Grid whole = phantom.spec().imaging_grid();
  const auto frame = phantom.frame(phantom.phase_time_s(0));
  for (int k = 0; k < whole.size[2]; ++k) {
    for (int j = 0; j < whole.size[1]; ++j) {
      for (int i = 0; i < whole.size[0]; ++i) {
        const bool inside = frame->contains(Structure::Heart, whole.mm(i, j, k));
        const Index3 at{i - made.first[0], j - made.first[1], k - made.first[2]};
        const float share =
            made.grid.contains(at[0], at[1], at[2])
                ? made.phases.at(Structure::Heart)[0][made.grid.offset(at[0], at[1], at[2])]
                : 0.0F;
        EXPECT_TRUE(inside ? share > 0 : share < 1) << share << " at " << i << " " << j << " " << k;
      }
    }
  }
}

TEST(PhantomCoverage, IsTheSameOnOneThreadAndTwoAndOfDegradedImages) {
  PhantomSpec spec = quick("small");
  spec.anatomy = ventricles_alone(spec.anatomy);
  StageContext context;
  set_thread_count(1);
  const CoverageCycle one = true_coverage(Phantom(spec), context);
  set_thread_count(2);
  spec.scanner.shift_sigma_mm = 2;
  const CoverageCycle two = true_coverage(Phantom(spec), context);
  set_thread_count(0);
  EXPECT_EQ(one.phases, two.phases);
  EXPECT_EQ(one.phases.size(), 4U);
}

}  // namespace
}  // namespace beatlas::phantom
