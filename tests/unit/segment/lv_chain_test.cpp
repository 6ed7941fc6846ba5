/// Which end of a chain of pools is the base, and what of it is another chamber's.
#include "pipeline/segment/lv_chain.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace beatlas::segment {
namespace {

constexpr int kPhases = 12;

/// A pool that swings from one area at end-diastole (phase 0) to another at end-systole.
Candidate pool(int k, double end_diastole_mm2, double end_systole_mm2, double score) {
  Candidate out;
  out.k = k;
  out.score = score;
  for (int p = 0; p < kPhases; ++p) {
    const double empty = 0.5 * (1 - std::cos(2 * std::numbers::pi * p / kPhases));
    Ring ring;
    ring.area_mm2 = end_diastole_mm2 + empty * (end_systole_mm2 - end_diastole_mm2);
    out.rings.push_back(ring);
  }
  return out;
}

/// Slices from apex to base; the last ones are what lies beyond the valve.
std::vector<Candidate> ventricle(std::vector<Candidate> beyond) {
  std::vector<Candidate> out{pool(2, 700, 350, 24),   pool(3, 1200, 600, 28),
                             pool(4, 1700, 850, 22),  pool(5, 2000, 950, 23),
                             pool(6, 2150, 1000, 33), pool(7, 2150, 1000, 33)};
  out.insert(out.end(), beyond.begin(), beyond.end());
  return out;
}

std::vector<Candidate> turned(std::vector<Candidate> chain) {
  std::reverse(chain.begin(), chain.end());
  for (Candidate& c : chain) c.k = 20 - c.k;
  return chain;
}

std::vector<int> slices(const std::vector<Candidate>& chain) {
  std::vector<int> out(chain.size());
  std::transform(chain.begin(), chain.end(), out.begin(), [](const Candidate& c) { return c.k; });
  return out;
}

TEST(LvChain, WidensTowardTheBaseWhateverOneSliceAtItsEndHolds) {
  const std::vector<std::vector<Candidate>> ends{
      {},
      {pool(8, 2100, 2300, 12)},                         // the valve's plane passes through
      {pool(8, 2100, 2300, 12), pool(9, 180, 2900, 4)},  // a sliver, and an atrium in systole
      {pool(8, 400, 500, 3)}};                           // the root of the aorta
  for (const std::vector<Candidate>& beyond : ends) {
    EXPECT_EQ(side_of_base(ventricle(beyond), 0), 1) << beyond.size();
    EXPECT_EQ(side_of_base(turned(ventricle(beyond)), 0), -1) << beyond.size();
  }
}

TEST(LvChain, PoolsThatFillAsTheVentricleEmptiesAreNotOfIt) {
  const std::vector<double> beat =
      beats(ventricle({pool(8, 2100, 2300, 12), pool(9, 1800, 3900, 4)}));
  ASSERT_EQ(beat.size(), 8U);
  for (std::size_t n = 0; n < 6; ++n) EXPECT_NEAR(beat[n], 1, 0.4) << n;
  EXPECT_LT(beat[6], 0);
  EXPECT_LT(beat[7], 0);
}

TEST(LvChain, EndsWhereAtriaBeginAndWhereTheApexDoes) {
  for (const bool turn : {false, true}) {
    const auto dropped = [&](std::vector<Candidate> chain) {
      if (turn) chain = turned(std::move(chain));
      drop_others(chain, turn ? -1 : 1, 0);
      if (turn) chain = turned(std::move(chain));
      return slices(chain);
    };
    const std::vector<int> all{2, 3, 4, 5, 6, 7};
    EXPECT_EQ(dropped(ventricle({})), all);
    // One slice that the base passes through stays, atria beyond it go.
    const std::vector<int> and_base{2, 3, 4, 5, 6, 7, 8};
    EXPECT_EQ(dropped(ventricle({pool(8, 2100, 2300, 12)})), and_base);
    EXPECT_EQ(dropped(ventricle({pool(8, 2100, 2300, 12), pool(9, 1900, 4000, 3)})), and_base);
    EXPECT_EQ(dropped(ventricle(
                  {pool(8, 2100, 2300, 12), pool(9, 1900, 4000, 3), pool(10, 3200, 3190, 5)})),
              and_base);
    // The liver below the apex is wider and no ring.
    std::vector<Candidate> liver = ventricle({});
    liver.insert(liver.begin(), pool(1, 2400, 2200, 2));
    EXPECT_EQ(dropped(liver), all);
  }
}

}  // namespace
}  // namespace beatlas::segment
