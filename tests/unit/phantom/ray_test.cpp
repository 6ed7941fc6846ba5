#include "pipeline/phantom/ray.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace beatlas::phantom {
namespace {

const Ellipsoid kEgg{{1.0, 2.0, 3.0}, {3.0, 4.0, 5.0}};
const Ellipsoid kTube{{0.0, 0.0, 0.0}, {3.0, 4.0, std::numeric_limits<double>::infinity()}};

TEST(Crossings, OfAnEllipsoidLieOnItAndAscend) {
  const Vec3 origin(-20.0, 1.0, 0.5);
  const Vec3 direction = (kEgg.centre_mm + Vec3(0.3, -0.5, 1.0) - origin).normalized();
  const std::vector<double> found = crossings(kEgg, origin, direction);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_LT(found[0], found[1]);
  for (const double s : found) EXPECT_NEAR(kEgg.level(origin + s * direction), 0.0, 1e-12);
  EXPECT_TRUE(crossings(kEgg, origin, Vec3::UnitY()).empty());
  // From inside and away: one behind, one ahead; along an axis exactly the semi-axis.
  const std::vector<double> within = crossings(kEgg, kEgg.centre_mm, Vec3::UnitZ());
  ASSERT_EQ(within.size(), 2U);
  EXPECT_NEAR(within[0], -5.0, 1e-12);
  EXPECT_NEAR(within[1], 5.0, 1e-12);
}

TEST(Crossings, OfATubeAreThoseOfItsSection) {
  EXPECT_TRUE(crossings(kTube, Vec3(1.0, 1.0, 7.0), Vec3::UnitZ()).empty()) << "along its axis";
  const std::vector<double> across = crossings(kTube, Vec3(-10.0, 0.0, 7.0), Vec3::UnitX());
  ASSERT_EQ(across.size(), 2U);
  EXPECT_NEAR(across[0], 7.0, 1e-12);
  EXPECT_NEAR(across[1], 13.0, 1e-12);
  // At 60 degrees to the axis it takes 1 / sin 60 as long.
  const Vec3 slant(std::sqrt(0.75), 0.0, 0.5);
  const std::vector<double> along = crossings(kTube, Vec3::Zero(), slant);
  ASSERT_EQ(along.size(), 2U);
  EXPECT_NEAR(along[1], 3.0 / std::sqrt(0.75), 1e-12);
}

TEST(Crossings, OfAPlaneIsOneUnlessTheLineRunsAlongIt) {
  EXPECT_EQ(crossings(Below{4.0}, Vec3(0, 0, 1), Vec3::UnitZ()), std::vector<double>{3.0});
  EXPECT_TRUE(crossings(Below{4.0}, Vec3(0, 0, 1), Vec3::UnitX()).empty());
}

TEST(Spans, OfASolidAreThoseThatDenseSamplingFinds) {
  // A shell cut flat, and the same with what a tube cuts out of it filled again.
  const Ellipsoid inner{{1.0, 2.0, 3.0}, {2.0, 3.0, 4.0}};
  const Solid shell({kEgg, inner, Below{6.0}}, {{{0, true}, {1, false}, {2, true}}}, 0.5);
  const auto bored = [&](const Vec3& x) {
    return shell.contains(x) || (kTube.level(x) < 0.0 && kEgg.level(x) < 0.0 && x.z() < 6.0);
  };
  constexpr double kStep = 1e-3;
  const Span within{-12.0, 12.0};
  for (int n = 0; n < 40; ++n) {
    const Vec3 origin(0.9 + 0.05 * n, 2.3 - 0.07 * n, 2.0 + 0.1 * n);
    const Vec3 direction = Vec3(std::cos(2.4 * n), std::sin(2.4 * n), -1.0 + 0.05 * n).normalized();
    const auto sampled = [&](const auto& contains) {
      double sum = 0.0;
      for (double s = within.from_mm + 0.5 * kStep; s < within.to_mm; s += kStep) {
        if (contains(origin + s * direction)) sum += kStep;
      }
      return sum;
    };
    const auto length = [&](const std::vector<Span>& spans) {
      double sum = 0.0;
      double end = within.from_mm - 1.0;
      for (const Span& span : spans) {
        EXPECT_GT(span.from_mm, end) << "apart and ascending";
        end = span.to_mm;
        sum += span.length_mm();
      }
      return sum;
    };
    // Each end falls within a step.
    EXPECT_NEAR(length(spans_inside(shell, origin, direction, within)),
                sampled([&](const Vec3& x) { return shell.contains(x); }), 6.0 * kStep);
    EXPECT_NEAR(
        length(spans_inside({kEgg, inner, Below{6.0}, kTube}, bored, origin, direction, within)),
        sampled(bored), 6.0 * kStep);
  }
}

TEST(Spans, InTheMuscleEndOnItsSurface) {
  // Holds the primitives of the ray against the phantom's own muscle, whatever that is made of.
  for (const std::string& name : preset_names()) {
    const Phantom phantom(preset(name));
    for (const double share : {0.0, 0.3, 0.7}) {
      const auto frame = phantom.frame(share * phantom.spec().rr_interval_s);
      int met = 0;
      for (const Vec3& at : frame->sample_surface(Structure::LvBlood, 12.0)) {
        const Vec3 outward = frame->nearest(Structure::LvBlood, at).outward;
        for (const Span& span :
             spans_in_lv_muscle(*frame, phantom.spec().anatomy, at, outward, {-150.0, 150.0})) {
          for (const double s : {span.from_mm, span.to_mm}) {
            EXPECT_LT(std::abs(frame->distance_mm(Structure::LvMyocardium, at + s * outward)), 1e-6)
                << name;
          }
          EXPECT_TRUE(frame->contains(Structure::LvMyocardium,
                                      at + 0.5 * (span.from_mm + span.to_mm) * outward));
          ++met;
        }
      }
      EXPECT_GT(met, 20) << name;
    }
  }
}

}  // namespace
}  // namespace beatlas::phantom
