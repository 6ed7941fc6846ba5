#include "pipeline/field/repair_topology.h"

#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/field/interpolant.h"
#include "pipeline/field/simple_topology.h"
#include "runtime/base/error.h"
#include "tests/unit/mesh/beating_shapes.h"

namespace beatlas::field {
namespace {

using closed_form::beating_field;

constexpr int kAlike = 3;  ///< phases, all the same
constexpr double kRadiusMm = 14;
const Vec3 kBall(-5, 0, 0);
/// Triangles of level_surface have sides of up to 1.4 voxels, whose middles lie 2.1^2 / (8 R) mm
/// within the ball.
constexpr double kOffMm = 0.04;

double ball_mm(const Vec3& x, const Vec3& centre, double radius_mm) {
  return (x - centre).norm() - radius_mm;
}

FieldCycle cycle_of(const std::function<double(const Vec3&)>& level) {
  return beating_field([&](double, const Vec3& x) { return level(x); }, kAlike, {-28, -24, -24},
                       {36, 24, 24}, Handles::Keep);
}

std::string repaired(FieldCycle& field) {
  StageContext context;
  std::string log;
  context.warn_sink = [&](std::string_view line) { log += line; };
  repair_topology(field, context);
  return log;
}

/// The farthest that a sample lies from the clamped distance of the one ball.
double worst_off_ball_mm(const FieldCycle& field, std::size_t phase) {
  const Grid& grid = field.distance_mm.grid;
  double worst = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const double want = std::clamp(ball_mm(grid.mm(i, j, k), kBall, kRadiusMm), -field.inner_mm,
                                       field.outer_mm);
        const double got = field.distance_mm.phases[phase][grid.offset(i, j, k)];
        worst = std::max(worst, std::abs(got - want));
      }
    }
  }
  return worst;
}

double ball_ml() { return 4.0 / 3 * std::numbers::pi * std::pow(kRadiusMm, 3) * 1e-3; }

void expect_the_ball(const FieldCycle& field) {
  for (std::size_t p = 0; p < kAlike; ++p) {
    EXPECT_LT(worst_off_ball_mm(field, p), kOffMm) << p;
    EXPECT_NEAR(field.volume_ml[p] / ball_ml(), 1, 0.005) << p;
  }
}

TEST(RepairTopology, APieceThatGoesLeavesNothingToFeel) {
  FieldCycle field = cycle_of([](const Vec3& x) {
    return std::min(ball_mm(x, kBall, kRadiusMm), ball_mm(x, {20, 0, 0}, 4));
  });
  ASSERT_GT(field.volume_ml[0], ball_ml() + 0.2);
  const std::string log = repaired(field);
  EXPECT_NE(log.find("2 pieces, 0 hollows and 0 handles"), std::string::npos) << log;
  expect_the_ball(field);
}

TEST(RepairTopology, AHollowIsAsDeepAsTheBodyAroundIt) {
  FieldCycle field = cycle_of([](const Vec3& x) {
    return std::max(ball_mm(x, kBall, kRadiusMm), -ball_mm(x, kBall + Vec3(2, 1, 0), 4));
  });
  ASSERT_LT(field.volume_ml[0], ball_ml() - 0.2);
  const std::string log = repaired(field);
  EXPECT_NE(log.find("1 piece, 1 hollow and 0 handles"), std::string::npos) << log;
  expect_the_ball(field);
}

TEST(RepairTopology, ABridgeIsADistanceTooAndMovesNothingFarFromIt) {
  // A piece that is deeper than its way to the body is long, 3 mm.
  const Vec3 middle(10.5, 0, 0);
  FieldCycle field = cycle_of([](const Vec3& x) {
    return std::min(ball_mm(x, kBall, kRadiusMm), ball_mm(x, {20, 0, 0}, 8));
  });
  const FieldCycle before = field;
  (void)repaired(field);
  const Grid& grid = field.distance_mm.grid;
  const double step_mm = field.voxel_mm + 0.1;  // faces of the bridge are flat
  for (std::size_t p = 0; p < kAlike; ++p) {
    const std::vector<float>& d = field.distance_mm.phases[p];
    EXPECT_TRUE(topology_of(grid, d).is_ball()) << p;
    EXPECT_LT(Interpolant(grid, d).value(middle), 0) << p;
    EXPECT_GT(field.volume_ml[p], before.volume_ml[p]) << p;
    for (int k = 1; k < grid.size[2]; ++k) {
      for (int j = 1; j < grid.size[1]; ++j) {
        for (int i = 1; i < grid.size[0]; ++i) {
          const std::size_t here = grid.offset(i, j, k);
          ASSERT_LE(std::abs(d[here] - d[grid.offset(i - 1, j, k)]), step_mm);
          ASSERT_LE(std::abs(d[here] - d[grid.offset(i, j - 1, k)]), step_mm);
          ASSERT_LE(std::abs(d[here] - d[grid.offset(i, j, k - 1)]), step_mm);
          // The bridge and the eased samples around it lie within 10 mm of its middle.
          const double away_mm = (grid.mm(i, j, k) - middle).norm() - 10;
          const float old = before.distance_mm.phases[p][here];
          if (away_mm > std::abs(old) + 2 * field.voxel_mm) {
            ASSERT_EQ(d[here], old);
          }
        }
      }
    }
  }
}

/// A shell of muscle with a hole of 2 mm radius, and the blood in it, which reaches out through it.
struct Holed {
  FieldCycle muscle, blood;
  explicit Holed(double shell_top_mm) {
    const auto hole_mm = [](const Vec3& x) {
      return std::max(std::hypot(x.y(), x.z()) - 2, 2 - x.x());
    };
    const auto blood_mm = [=](const Vec3& x) {
      const double finger = std::max(hole_mm(x), x.x() - 22);
      return std::min(std::max(x.norm() - 14, x.z() - shell_top_mm), finger);
    };
    blood = beating_field([=](double, const Vec3& x) { return blood_mm(x); }, kAlike,
                          {-30, -30, -30}, {34, 30, 30}, Handles::Keep);
    blood.structure = Structure::LvBlood;
    muscle = beating_field(
        [=](double, const Vec3& x) {
          return std::max({x.norm() - 17, x.z() - shell_top_mm, -blood_mm(x)});
        },
        kAlike, {-30, -30, -30}, {34, 30, 30}, Handles::Keep);
    muscle.structure = Structure::LvMyocardium;
  }
};

TEST(RepairTopology, BloodLeavesTheHoleThatMuscleClosesAndWhatReachesBeyond) {
  Holed made(12);
  std::vector<FieldCycle> fields{made.blood, made.muscle};
  ASSERT_LT(
      Interpolant(made.blood.distance_mm.grid, made.blood.distance_mm.phases[0]).value({19, 0, 0}),
      -2);
  ASSERT_EQ(topology_of(made.muscle.distance_mm.grid, made.muscle.distance_mm.phases[0]).handles,
            1);
  StageContext context;
  repair_topology(fields, context);
  for (std::size_t p = 0; p < kAlike; ++p) {
    const Interpolant blood(fields[0].distance_mm.grid, fields[0].distance_mm.phases[p]);
    const Interpolant muscle(fields[1].distance_mm.grid, fields[1].distance_mm.phases[p]);
    EXPECT_TRUE(topology_of(fields[0].distance_mm.grid, fields[0].distance_mm.phases[p]).is_ball());
    EXPECT_TRUE(topology_of(fields[1].distance_mm.grid, fields[1].distance_mm.phases[p]).is_ball());
    EXPECT_LT(muscle.value({15.5, 0, 0}), 0);
    EXPECT_GT(blood.value({19, 0, 0}), 0);
    double overlap_mm = 0;
    for (double z = -20; z <= 20; z += 0.5) {
      for (double y = -20; y <= 20; y += 0.5) {
        for (double x = -20; x <= 24; x += 0.5) {
          const Vec3 at(x, y, z);
          overlap_mm = std::max(overlap_mm, -std::max(blood.value(at), muscle.value(at)));
        }
      }
    }
    EXPECT_LT(overlap_mm, 0.3);
  }
}

TEST(RepairTopology, TheHeartTakesInWhatItsPartsHadToGainBeyondIt) {
  // A shell of muscle with two holes, which lead from outside into the heart as dents: one of them
  // has to be filled, for to cut the wall from one to the other would change far more.
  const auto heart_mm = [](const Vec3& x) {
    const double holes = std::max(std::hypot(x.y(), x.z()) - 2, 2 - std::abs(x.x()));
    return std::max(x.norm() - 17, -holes);
  };
  const auto muscle_mm = [=](const Vec3& x) { return std::max(heart_mm(x), 14 - x.norm()); };
  std::vector<FieldCycle> fields{cycle_of(muscle_mm), cycle_of(heart_mm)};
  fields[0].structure = Structure::LvMyocardium;
  fields[1].structure = Structure::Heart;
  StageContext context;
  repair_topology(fields, context);
  for (std::size_t p = 0; p < kAlike; ++p) {
    const Interpolant muscle(fields[0].distance_mm.grid, fields[0].distance_mm.phases[p]);
    const Interpolant heart(fields[1].distance_mm.grid, fields[1].distance_mm.phases[p]);
    EXPECT_TRUE(topology_of(fields[0].distance_mm.grid, fields[0].distance_mm.phases[p]).is_ball());
    EXPECT_TRUE(topology_of(fields[1].distance_mm.grid, fields[1].distance_mm.phases[p]).is_ball());
    double beyond_mm = 0;
    for (double z = -12; z <= 12; z += 0.5) {
      for (double y = -12; y <= 22; y += 0.5) {
        for (double x = -20; x <= 22; x += 0.5) {
          const Vec3 at(x, y, z);
          if (muscle.value(at) < 0) beyond_mm = std::max(beyond_mm, heart.value(at));
        }
      }
    }
    EXPECT_LT(beyond_mm, 0.3);
  }
}

TEST(RepairTopology, BloodThatMuscleEnclosesStays) {
  std::vector<FieldCycle> fields{
      cycle_of([](const Vec3& x) { return std::abs(x.norm() - 12) - 3; }),
      cycle_of([](const Vec3& x) { return x.norm() - 9; })};
  fields[0].structure = Structure::LvMyocardium;
  fields[1].structure = Structure::LvBlood;
  const std::vector<std::vector<float>> blood = fields[1].distance_mm.phases;
  const Grid grid = fields[0].distance_mm.grid;
  ASSERT_EQ(topology_of(grid, fields[0].distance_mm.phases[0]).hollows, 1);
  StageContext context;
  repair_topology(fields, context);
  ASSERT_TRUE(topology_of(grid, fields[0].distance_mm.phases[0]).is_ball());
  EXPECT_EQ(fields[1].distance_mm.phases, blood);
}

TEST(RepairTopology, TheHeartIsTheSameWhateverElseIsMade) {
  // Two pieces of the RV that are joined beyond the heart.
  const auto heart = cycle_of([](const Vec3& x) { return ball_mm(x, kBall, kRadiusMm); });
  FieldCycle rv = cycle_of([](const Vec3& x) {
    return std::min(ball_mm(x, {17, -7, 0}, 6), ball_mm(x, {17, 7, 0}, 6));
  });
  rv.structure = Structure::RvBlood;
  std::vector<FieldCycle> alone{heart};
  std::vector<FieldCycle> both{rv, heart};
  StageContext context;
  repair_topology(alone, context);
  repair_topology(both, context);
  EXPECT_TRUE(topology_of(both[0].distance_mm.grid, both[0].distance_mm.phases[0]).is_ball());
  EXPECT_LT(Interpolant(both[0].distance_mm.grid, both[0].distance_mm.phases[0]).value({17, 0, 0}),
            0);
  EXPECT_EQ(alone[0].distance_mm.phases, both[1].distance_mm.phases);
}

TEST(RepairTopology, APhaseBetweenSamplesIsRefusedByName) {
  FieldCycle field = cycle_of([](const Vec3& x) { return ball_mm(x, kBall, kRadiusMm); });
  field.structure = Structure::Aorta;
  for (const std::size_t phase : {0, 1, 2}) {
    FieldCycle broken = field;
    for (float& mm : broken.distance_mm.phases[phase]) mm = std::max(mm, 0.2F);
    StageContext context;
    try {
      repair_topology(broken, context);
      FAIL() << "not refused";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      EXPECT_NE(std::string(error.what()).find("phase " + std::to_string(phase) + " of aorta"),
                std::string::npos)
          << error.what();
    }
  }
}

TEST(RepairTopology, FieldsThatDoNotBelongTogetherAreRefused) {
  FieldCycle heart = cycle_of([](const Vec3& x) { return ball_mm(x, kBall, kRadiusMm); });
  FieldCycle rv = heart;
  rv.structure = Structure::RvBlood;
  rv.distance_mm.phases.pop_back();
  std::vector<FieldCycle> fields{heart, rv};
  StageContext context;
  EXPECT_THROW(repair_topology(fields, context), Error);
}

TEST(RepairTopology, TheSameBitsForAnyNumberOfThreads) {
  FieldCycle alone = cycle_of([](const Vec3& x) {
    return std::min(ball_mm(x, kBall, kRadiusMm), ball_mm(x, {20, 0, 0}, 8));
  });
  FieldCycle together = alone;
  set_thread_count(1);
  (void)repaired(alone);
  set_thread_count(4);
  (void)repaired(together);
  set_thread_count(0);
  EXPECT_EQ(alone.distance_mm.phases, together.distance_mm.phases);
  EXPECT_EQ(alone.volume_ml, together.volume_ml);
}

TEST(RepairTopology, ACycleOfBallsStaysAsItIs) {
  FieldCycle field = cycle_of([](const Vec3& x) { return ball_mm(x, kBall, kRadiusMm); });
  const FieldCycle before = field;
  EXPECT_EQ(repaired(field), "");
  EXPECT_EQ(field.distance_mm.phases, before.distance_mm.phases);
  EXPECT_EQ(field.volume_ml, before.volume_ml);
}

}  // namespace
}  // namespace beatlas::field
