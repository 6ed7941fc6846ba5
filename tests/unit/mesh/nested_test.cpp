#include "pipeline/mesh/nested.h"

#include <gtest/gtest.h>

#include "pipeline/assess/surface_checks.h"
#include "pipeline/mesh/beyond_base.h"
#include "pipeline/mesh/levels.h"
#include "tests/unit/mesh/beating_shapes.h"
#include "tests/unit/mesh/expect_sound.h"

namespace beatlas::mesh {
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

TEST(WithoutVentricles, AnAtriumIsMeshedWhereItCrossesNone) {
  Ventricle made = ventricle();
  made.fields.erase(made.fields.begin());
  made.surfaces.erase(made.surfaces.begin());
  // Up to 3 mm deep in the ventricle's blood and its muscle, the latter at an angle.
  const auto atrium = [](double share, const Vec3& x) {
    const double base = 30 - 14 * share;
    return std::max(closed_form::ellipsoid_level({{0, 0, base + 6}, {28, 28, 18}}, x),
                    base - 3 * std::cos(x.x() / 12) - x.z());
  };
  made.add(Structure::LaBlood, atrium);
  constexpr double kEdgeMm = 2;
  const FieldCycle apart = without_ventricles(made.fields[2], made.fields, kEdgeMm);
  // Of the closed forms: inside where the atrium is and neither blood nor muscle.
  const Grid& grid = apart.distance_mm.grid;
  std::size_t changed = 0;
  std::size_t v = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++v) {
        const Vec3 x = grid.mm(i, j, k);
        const double ventricle_level = std::min(blood_of_cup(0, x), closed_form::cup(0, x));
        const double level = std::max(atrium(0, x), -ventricle_level);
        const float is = apart.distance_mm.phases[0][v];
        if (std::abs(level) > 0.5) {
          ASSERT_EQ(is < 0, level < 0) << x.transpose();
        }
        changed += is != made.fields[2].distance_mm.phases[0][v] ? 1 : 0;
      }
    }
  }
  EXPECT_GT(changed, 1000U);

  const auto with_atrium = [&](std::size_t n) {
    return Ventricle::crossings({made.surfaces[n], made.surfaces[2]});
  };
  const std::array before{with_atrium(0), with_atrium(1)};
  StageContext context;
  made.surfaces[2] = mesh_cycle(apart, {}, context);
  std::cout << before[0] << " and " << before[1] << " crossings became " << with_atrium(0)
            << " and " << with_atrium(1) << '\n';
  EXPECT_LT(with_atrium(0), before[0] / 2);
  EXPECT_LT(with_atrium(1), before[1] / 2);
  part_structures(made.surfaces, made.fields);
  EXPECT_EQ(Ventricle::crossings(made.surfaces), 0U);
  expect_sound(made.surfaces[2]);
  EXPECT_LT(error_against(apart, made.surfaces[2]).mean_mm, 0.1);
}

TEST(PartStructures, LeavesWhatTouchesNothingAsItIs) {
  Ventricle made = ventricle();
  made.surfaces.resize(1);  // the heart alone
  std::vector<SurfaceCycle> parted = made.surfaces;
  part_structures(parted, made.fields);
  EXPECT_EQ(parted[0].positions, made.surfaces[0].positions);
}

}  // namespace
}  // namespace beatlas::mesh
