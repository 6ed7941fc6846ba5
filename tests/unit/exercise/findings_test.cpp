/// Marks and measures of a palpation whose every tick is known.
#include "runtime/exercise/findings.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "runtime/exercise/score.h"
#include "tests/unit/palpation/sample_wall.h"

namespace beatlas::exercise {
namespace {

using palpation::test::kRadiusMm;
using palpation::test::SampleWall;

constexpr double kWallMm = 6;

struct Ball {
  SampleWall sample{16};
  palpation::LvWall wall = sample.wall();
  Ground ground{.wall = wall, .touchable = {}};
  Exercise asked;
  Ball() {
    for (const float mm : wall.wall_mm()) ground.touchable.push_back(mm > 0);
  }
  /// The outside over a direction at a moment.
  [[nodiscard]] static Vec3 outside(const Vec3& unit, double beats) {
    const double beat = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * beats);
    return (kRadiusMm - 5 * beat + kWallMm) * unit;
  }
  [[nodiscard]] static FeltTick tick(double time_s, const Vec3& unit, double force_n,
                                     std::uint32_t buttons = 0) {
    const double beats = 0.9 * time_s;
    return {.time_s = time_s,
            .beats = beats,
            .tool_mm = outside(unit, beats),
            .contact_mm = outside(unit, beats),
            .touching = force_n > 0,
            .force_n = force_n,
            .buttons = buttons};
  }
};

Vec3 around(double angle, double z = 0) {
  const double across = std::sqrt(1 - z * z);
  return {across * std::cos(angle), across * std::sin(angle), z};
}

TEST(Findings, AMarkIsScoredToHalfAMillimetreAtAnyMoment) {
  const Ball ball;
  double worst_mm = 0;
  for (int n = 0; n < 60; ++n) {
    const std::uint32_t middle = static_cast<std::uint32_t>(7919 * (n + 1)) %
                                 static_cast<std::uint32_t>(ball.wall.vertex_count());
    if (!ball.ground.touchable[middle] || ball.wall.mm(middle).z() > 18) continue;
    // 6 mm beside the lesion's middle along the surface, marked at some time of the beat.
    const Vec3 unit = ball.wall.mm(middle).normalized();
    const Vec3 beside =
        Eigen::AngleAxisd(2 * std::asin(3 / kRadiusMm), unit.unitOrthogonal()) * unit;
    Examination examination(ball.asked, ball.ground, 5);
    const double at_s = 0.061 * n;
    examination.add(Ball::tick(at_s, beside, 0.5));
    examination.add(Ball::tick(at_s + 0.001, beside, 0.5, 2));
    const Findings found = examination.findings();
    ASSERT_EQ(found.marks.size(), 1U);
    EXPECT_EQ(found.marks[0].named, LesionKind::Thin);
    const Lesion lesion{.kind = LesionKind::Thin, .grade = 0.5, .radius_mm = 9, .vertex = middle};
    const Score score = score_of({lesion}, found, ball.wall);
    worst_mm = std::max(worst_mm, std::abs(score.lesions[0].distance_mm - 6));
    EXPECT_TRUE(score.lesions[0].found);
    EXPECT_TRUE(score.lesions[0].named);
  }
  EXPECT_GT(worst_mm, 0);
  EXPECT_LT(worst_mm, 0.5);
}

TEST(Findings, MeasuresAreThoseOfThePalpation) {
  const Ball ball;
  Examination examination(ball.asked, ball.ground, 2);
  // Half a second in air, one second around a quarter of the equator with a held heart, of which a
  // fifth at 3 N.
  const int ticks = 1000;
  for (int n = 0; n < 500; ++n) {
    FeltTick tick = Ball::tick(0.001 * n, around(0), 0);
    tick.tool_mm *= 2;
    examination.add(tick);
  }
  for (int n = 0; n <= ticks; ++n) {
    FeltTick tick =
        Ball::tick(0.5 + 0.001 * n, around(0.5 * std::numbers::pi * n / ticks), n <= 800 ? 1 : 3);
    tick.beats = 0;
    tick.tool_mm = tick.contact_mm = Ball::outside(around(0.5 * std::numbers::pi * n / ticks), 0);
    examination.add(tick);
  }
  const Palpation p = examination.findings().palpation;
  EXPECT_NEAR(p.time_s, 1.5, 1e-9);
  EXPECT_NEAR(p.contact_s, 1.0, 2e-3);
  EXPECT_NEAR(p.path_mm, 0.5 * std::numbers::pi * (kRadiusMm + kWallMm), 0.01);
  EXPECT_EQ(p.peak_n, 3);
  EXPECT_NEAR(p.mean_n, 0.8 * 1 + 0.2 * 3, 5e-3);
  EXPECT_NEAR(p.harmful_s, 0.2, 1e-9);
  // A band 10 mm wide and a quarter of the equator long, with round ends, of the ball less its
  // base.
  const double band = 10 * 0.5 * std::numbers::pi * kRadiusMm + std::numbers::pi * 25;
  EXPECT_NEAR(p.share, band / (4 * std::numbers::pi * kRadiusMm * kRadiusMm * 0.95), 0.02);
}

TEST(Findings, AButtonCountsWhenItGoesDownOnWhatWasTouched) {
  const Ball ball;
  Examination examination(ball.asked, ball.ground, 5);
  examination.add(Ball::tick(0, around(0), 0, 1));      // down from the start
  examination.add(Ball::tick(0.001, around(0), 0, 0));  // let go
  examination.add(Ball::tick(0.002, around(0), 0, 1));  // nothing was touched yet
  examination.add(Ball::tick(0.003, around(1), 0.4, 1));
  EXPECT_EQ(examination.findings().marks.size(), 0U);
  examination.add(Ball::tick(0.004, around(1), 0, 0));
  examination.add(Ball::tick(0.005, around(2), 0, 1));       // in air: what was touched last
  examination.add(Ball::tick(0.006, around(2), 0, 1));       // held
  examination.add(Ball::tick(0.007, around(2), 0, 1 | 16));  // no kind has that button
  const std::vector<Mark> marks = examination.findings().marks;
  ASSERT_EQ(marks.size(), 1U);
  EXPECT_EQ(marks[0].named, LesionKind::Soft);
  EXPECT_LT((marks[0].place.mm - kRadiusMm * around(1)).norm(), 0.5);
  EXPECT_NEAR(marks[0].time_s, 0.005, 1e-12);
}

TEST(Score, GivesEachLesionItsNearestMark) {
  const Ball ball;
  const std::uint32_t a = ball.wall.nearest(kRadiusMm * around(0), 0).vertex;
  const std::uint32_t b = ball.wall.nearest(kRadiusMm * around(2), 0).vertex;
  Findings found;
  found.palpation = {.contact_s = 10, .share = 0.4, .harmful_s = 0.5};
  const auto mark = [&](double angle, LesionKind kind) {
    return Mark{.named = kind, .place = ball.wall.material_at(kRadiusMm * around(angle), 0)};
  };
  const std::vector<Lesion> lesions{{LesionKind::Scar, 0.5, 10, a}, {LesionKind::Soft, 0.5, 10, b}};
  found.marks = {mark(2.1, LesionKind::Soft), mark(0.2, LesionKind::Thin)};
  const Score score = score_of(lesions, found, ball.wall);
  EXPECT_EQ(*score.lesions[0].mark, 1U);
  EXPECT_TRUE(score.lesions[0].found);
  EXPECT_FALSE(score.lesions[0].named);
  EXPECT_TRUE(score.lesions[1].named);
  EXPECT_EQ(score.false_marks, 0);
  // 60 and 80 for the lesions, half of the wall that counts, half of the harm that is borne.
  EXPECT_NEAR(score.points, 70 + 5 + 5, 1e-9);
  // A mark 1.5 radii away is worth half its place; a third mark costs.
  found.marks = {mark(2.0 + 15 / kRadiusMm, LesionKind::Soft)};
  const Score half = score_of({lesions[1]}, found, ball.wall);
  EXPECT_FALSE(half.lesions[0].found);
  EXPECT_EQ(half.false_marks, 1);
  EXPECT_NEAR(half.lesions[0].distance_mm, 2 * kRadiusMm * std::sin(7.5 / kRadiusMm), 1.5);
  EXPECT_NEAR(half.points, 60 * (2 - half.lesions[0].distance_mm / 10) + 10, 1e-9);
  found.marks.push_back(mark(-1, LesionKind::Soft));
  EXPECT_NEAR(score_of({lesions[1]}, found, ball.wall).points, half.points - 20, 1e-9);
  found.marks.clear();
  const Score none = score_of(lesions, found, ball.wall);
  EXPECT_FALSE(none.lesions[0].mark);
  EXPECT_NEAR(none.points, 10, 1e-9);
}

TEST(Score, HarmfulForceIsDiastolicPressureOnTheFingertip) {
  // 80 mmHg are 10.67 kPa; on 3 cm^2 3.2 N.
  EXPECT_NEAR(harmful_force_n(80, 3), 3.1997, 1e-3);
}

}  // namespace
}  // namespace beatlas::exercise
