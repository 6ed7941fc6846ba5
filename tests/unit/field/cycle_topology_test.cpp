#include "pipeline/field/cycle_topology.h"

#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/field/interpolant.h"
#include "pipeline/field/repair_topology.h"
#include "pipeline/mesh/mesh.h"
#include "tests/unit/mesh/beating_shapes.h"
#include "tests/unit/mesh/expect_sound.h"

namespace beatlas::field {
namespace {

using closed_form::beating_field;

constexpr int kPhases = 6;

/// Three balls that touch, as atria and aorta do: two of them `apart_mm` from each other, both 27
/// from the third.
struct Ring {
  double radius_mm = 14;
  double apart_mm = 28;

  [[nodiscard]] double level(const Vec3& x) const {
    const double half = 0.5 * apart_mm;
    const Vec3 third(0, std::sqrt(27.2 * 27.2 - half * half) - 12, 0);
    return std::min({(x - Vec3(-half, -12, 0)).norm(), (x - Vec3(half, -12, 0)).norm(),
                     (x - third).norm()}) -
           radius_mm;
  }
};
const Vec3 kNeck(0, -12, 0);   // between the two
const Vec3 kHole(0, -4.5, 0);  // what all three leave

FieldCycle field_of(const std::function<Ring(double)>& ring) {
  return beating_field([&](double share, const Vec3& x) { return ring(share).level(x); }, kPhases,
                       {-36, -32, -20}, {36, 32, 20}, Handles::Keep);
}

/// At end-diastole a thread of 0.8 mm and a hole of 1.9; at end-systole the balls have grown over
/// both.
Ring growing(double share) { return {14 + 3.5 * share, 27.95}; }

/// At end-diastole a hole of less than a sample; later the two part.
Ring parting(double share) { return {14.6, 26 + 8 * share}; }

double at(const FieldCycle& field, std::size_t phase, const Vec3& x) {
  return Interpolant(field.distance_mm.grid, field.distance_mm.phases[phase]).value(x);
}

void make(FieldCycle& field) {
  const std::vector<Repair> repairs =
      make_balls(field.distance_mm.grid, field.distance_mm.phases, StageContext{});
  ASSERT_EQ(repairs.size(), std::size_t{kPhases});
  for (std::size_t p = 0; p < kPhases; ++p) {
    EXPECT_EQ(repairs[p].left_handles, 0);
    EXPECT_TRUE(topology_of(field.distance_mm.grid, field.distance_mm.phases[p]).is_ball()) << p;
  }
}

TEST(CycleTopology, WhatGrowsTogetherIsFilledAndNotCut) {
  FieldCycle field = field_of(growing);
  FieldCycle alone = field;
  EXPECT_EQ(make_ball(alone.distance_mm.grid, alone.distance_mm.phases[0]).before.handles, 1);
  EXPECT_GT(at(alone, 0, kNeck), 0);  // which costs less in that phase
  make(field);
  for (std::size_t p = 0; p < kPhases; ++p) {
    EXPECT_LT(at(field, p, kNeck), 0) << p;
    EXPECT_LT(at(field, p, kHole), 0) << p;
  }
}

TEST(CycleTopology, WhatPartsIsCutAndNotFilled) {
  FieldCycle field = field_of(parting);
  FieldCycle alone = field;
  EXPECT_EQ(make_ball(alone.distance_mm.grid, alone.distance_mm.phases[0]).before.handles, 1);
  EXPECT_LT(at(alone, 0, kNeck), 0);
  make(field);
  for (std::size_t p = 0; p < kPhases; ++p) EXPECT_GT(at(field, p, kNeck), 0) << p;
}

/// Two balls of 10 and 6 mm, 12 mm apart, and where there is one a stalk of 2.5 mm between them.
double stalked(const Vec3& x, bool has_stalk) {
  const double body = (x - Vec3(-14, 0, 0)).norm() - 10;
  const double part = (x - Vec3(14, 0, 0)).norm() - 6;
  const double stalk = std::max(std::hypot(x.y() - 3, x.z()) - 2.5, std::abs(x.x() - 2) - 9);
  return has_stalk ? std::min({body, part, stalk}) : std::min(body, part);
}

FieldCycle stalked_in(const std::function<bool(double)>& has_stalk) {
  return beating_field([&](double share, const Vec3& x) { return stalked(x, has_stalk(share)); },
                       kPhases, {-32, -20, -20}, {28, 20, 20}, Handles::Keep);
}

TEST(CycleTopology, APartThatLosesItsNeckInSomePhasesKeepsItWhereTheOthersHaveIt) {
  FieldCycle field = stalked_in([](double share) { return share > 0.5; });
  ASSERT_GT(at(field, 0, {2, 3, 0}), 2);
  make(field);
  for (std::size_t p = 0; p < kPhases; ++p) {
    for (double x = -6; x <= 9; x += 0.5) EXPECT_LT(at(field, p, {x, 3, 0}), 0) << p << ' ' << x;
    EXPECT_LT(at(field, p, {14, 0, 0}), -5) << p;
  }
}

TEST(CycleTopology, APartThatIsNeverTheBodyGoes) {
  FieldCycle field = stalked_in([](double) { return false; });
  make(field);
  for (std::size_t p = 0; p < kPhases; ++p) EXPECT_GT(at(field, p, {14, 0, 0}), 0) << p;
}

TEST(CycleTopology, ACycleOfBallsStaysAsItIs) {
  FieldCycle field = field_of([](double share) { return Ring{17 - share, 28}; });
  const std::vector<std::vector<float>> before = field.distance_mm.phases;
  make(field);
  EXPECT_EQ(field.distance_mm.phases, before);
}

TEST(CycleTopology, OneMeshGoesThroughACycleWhosePartsGrowTogether) {
  StageContext context;
  FieldCycle field = field_of(growing);
  repair_topology(field, context);
  const SurfaceCycle surface = mesh::mesh_cycle(field, {}, context);
  mesh::expect_sound(surface);
}

}  // namespace
}  // namespace beatlas::field
