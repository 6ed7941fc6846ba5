#include "pipeline/mesh/nested.h"

#include <gtest/gtest.h>

#include "pipeline/assess/surface_checks.h"
#include "pipeline/mesh/levels.h"
#include "tests/unit/mesh/beating_shapes.h"
#include "tests/unit/mesh/expect_sound.h"

namespace beatlas::mesh::nested_tests {
namespace {

constexpr int kPhases = 4;

/// The blood of closed_form::cup's ventricle, up to its base plane.
double blood_of_cup(double share, const Vec3& x) {
  const double a = 27 - 9.6 * share;
  const double c = 62 - 10.8 * share;
  const double apex = 6 + 2 * share;
  const Vec3 y = x - Vec3(0, 0, -68 + apex + c);
  return std::max(closed_form::ellipsoid_level({{0, 0, 0}, {a, a, c}}, y),
                  y.z() - 30 + 5.2 * share);
}

/// Muscle, its blood, and both together as the heart: every wall but the epicardium is shared
/// twice.
struct Ventricle {
  Ventricle() {
    add(Structure::Heart, [](double share, const Vec3& x) {
      return std::min(closed_form::cup(share, x), blood_of_cup(share, x));
    });
    add(Structure::LvBlood, blood_of_cup);
    add(Structure::LvMyocardium, closed_form::cup);
  }
  void add(Structure structure, const closed_form::BeatingLevel& level) {
    fields.push_back(closed_form::beating_field(level, kPhases, {-44, -44, -76}, {44, 44, 68}));
    fields.back().structure = structure;
    StageContext context;
    surfaces.push_back(mesh_cycle(fields.back(), {}, context));
  }
  [[nodiscard]] static std::size_t crossings(const std::vector<SurfaceCycle>& of) {
    std::size_t count = 0;
    for (std::size_t p = 0; p < kPhases; ++p) {
      for (std::size_t a = 0; a < of.size(); ++a) {
        for (std::size_t b = a + 1; b < of.size(); ++b) {
          count += assess::crossing_triangles(of[a].triangles, of[a].positions[p], of[b].triangles,
                                              of[b].positions[p]);
        }
      }
    }
    return count;
  }
  std::vector<FieldCycle> fields;
  std::vector<SurfaceCycle> surfaces;
};

/// Made once: most of what these tests cost.
const Ventricle& ventricle() {
  static const Ventricle made;
  return made;
}

TEST(PartStructures, ThatShareWallsDoNotCrossAndStayOnTheirFields) {
  const Ventricle& made = ventricle();
  ASSERT_GT(Ventricle::crossings(made.surfaces), 10000U);
  std::vector<SurfaceCycle> parted = made.surfaces;
  part_structures(parted, made.fields);
  EXPECT_EQ(Ventricle::crossings(parted), 0U);
  for (std::size_t n = 0; n < parted.size(); ++n) {
    SCOPED_TRACE(n);
    expect_sound(parted[n]);
    EXPECT_EQ(parted[n].triangles, made.surfaces[n].triangles);
    const SurfaceError before = error_against(made.fields[n], made.surfaces[n]);
    const SurfaceError after = error_against(made.fields[n], parted[n]);
    EXPECT_LT(after.mean_mm, before.mean_mm + 0.02);
    EXPECT_LT(std::abs(after.bias_mm), 0.05);
  }
}

TEST(PartStructures, TurnsNoTriangleOverWhereTheFieldsContradictEachOther) {
  // The heart ends 3 mm within its blood on one side: no wall can be parted there.
  Ventricle made = ventricle();
  const auto within = [](double share, const Vec3& x) {
    return std::max(std::min(closed_form::cup(share, x), blood_of_cup(share, x)),
                    x.x() - 15 - 2 * std::sin(x.z() / 4));
  };
  made.fields[0] = closed_form::beating_field(within, kPhases, {-44, -44, -76}, {44, 44, 38});
  made.fields[0].structure = Structure::Heart;
  StageContext context;
  made.surfaces[0] = mesh_cycle(made.fields[0], {}, context);
  std::vector<SurfaceCycle> parted = made.surfaces;
  part_structures(parted, made.fields);
  EXPECT_NE(parted[0].positions, made.surfaces[0].positions);
  for (const SurfaceCycle& surface : parted) {
    SCOPED_TRACE(structure_name(surface.structure));
    expect_sound(surface);
  }
}

TEST(PartStructures, AnAtriumThatReachesIntoTheVentricleGoesBackAlone) {
  // Its floor bulges through the base plane, 1.8 mm deep: more than the first rounds take back.
  Ventricle made = ventricle();
  made.fields.erase(made.fields.begin());  // the heart does not hold the atrium
  made.surfaces.erase(made.surfaces.begin());
  std::vector<SurfaceCycle> alone = made.surfaces;
  part_structures(alone, made.fields);
  made.add(Structure::LaBlood, [](double share, const Vec3& x) {
    const double base = 30 - 14 * share;
    const double floor = base + 1 - 2.8 * std::exp(-(x.x() * x.x() + x.y() * x.y()) / 150);
    return std::max(closed_form::ellipsoid_level({{0, 0, base + 6}, {24, 24, 18}}, x),
                    floor - x.z());
  });
  std::vector<SurfaceCycle> parted = alone;
  parted.push_back(made.surfaces.back());
  ASSERT_GT(Ventricle::crossings(parted), 500U);
  parted = made.surfaces;
  part_structures(parted, made.fields);
  EXPECT_EQ(Ventricle::crossings(parted), 0U);
  for (std::size_t n = 0; n < 2; ++n) EXPECT_EQ(parted[n].positions, alone[n].positions);
  expect_sound(parted[2]);
  EXPECT_LT(error_against(made.fields[2], parted[2]).mean_mm, 0.15);
}

TEST(PartStructures, WhatCrossesOffItsSurfaceGoesBackFromWhereItIs) {
  // On one side the muscle's mesh stands up to 0.9 mm in the blood, as it does where it bridges
  // what other phases have open: no distance tells of it.
  Ventricle made = ventricle();
  std::vector<SurfaceCycle> parted = made.surfaces;
  part_structures(parted, made.fields);
  ASSERT_EQ(Ventricle::crossings(parted), 0U);
  for (std::size_t p = 0; p < kPhases; ++p) {
    for (Vec3f& x : parted[2].positions[p]) {
      const Vec3 at = x.cast<double>();
      const double bulge = 0.9 * std::exp(-(at - Vec3(24, 0, -10)).squaredNorm() / 60);
      x -= Vec3f(static_cast<float>(bulge), 0, 0);
    }
  }
  const std::size_t before = Ventricle::crossings({parted[1], parted[2]});
  ASSERT_GT(before, 100U);
  part_structures(parted, made.fields);
  EXPECT_EQ(Ventricle::crossings({parted[1], parted[2]}), 0U) << "of " << before;
  for (const SurfaceCycle& surface : parted) expect_sound(surface);
}

TEST(PartStructures, OfOneThatIsHeldTheOthersGoBackAlone) {
  const Ventricle& made = ventricle();
  const std::size_t before = Ventricle::crossings(made.surfaces);
  std::vector<SurfaceCycle> parted = made.surfaces;
  part_structures(parted, made.fields, {Structure::LvMyocardium});
  EXPECT_EQ(parted[2].positions, made.surfaces[2].positions);
  EXPECT_NE(parted[1].positions, made.surfaces[1].positions);
  EXPECT_LT(Ventricle::crossings(parted), before / 100);
  for (const SurfaceCycle& surface : parted) expect_sound(surface);
}

TEST(PartStructures, LeavesWhatTouchesNothingAsItIs) {
  Ventricle made = ventricle();
  made.surfaces.resize(1);  // the heart alone
  std::vector<SurfaceCycle> parted = made.surfaces;
  part_structures(parted, made.fields);
  EXPECT_EQ(parted[0].positions, made.surfaces[0].positions);
}

}  // namespace
}  // namespace beatlas::mesh::nested_tests
