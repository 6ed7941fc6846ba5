#include "pipeline/assess/structural_checks.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "pipeline/assess/field_checks.h"
#include "pipeline/assess/surface_checks.h"
#include "runtime/atlas/scene.h"
#include "tests/unit/assess/made_candidate.h"

namespace beatlas::assess {
namespace {

const Triangles kTetrahedron{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

/// Corner of a cube of edge `edge_mm` anywhere: edge^3 / 6.
std::vector<Vec3f> corner(float edge_mm, const Vec3f& at) {
  return {at, at + Vec3f(edge_mm, 0, 0), at + Vec3f(0, edge_mm, 0), at + Vec3f(0, 0, edge_mm)};
}

/// Two tetrahedra, the second's vertices from `first_of_second` on.
Triangles two(std::uint32_t first_of_second) {
  Triangles out = kTetrahedron;
  for (auto triangle : kTetrahedron) {
    for (std::uint32_t& vertex : triangle) vertex = vertex == 0 ? first_of_second : vertex + 3;
    out.push_back(triangle);
  }
  return out;
}

TEST(EnclosedVolume, IsThatOfATetrahedronWhereverItLies) {
  for (const Vec3f& at : {Vec3f(0, 0, 0), Vec3f(100, -30, 7)}) {
    // Single-precision positions of 100 mm: 1e-5 mm on an edge of 60 mm.
    EXPECT_NEAR(enclosed_volume_ml(kTetrahedron, corner(60, at)), 36.0, 1e-4);
  }
}

TEST(EnclosedVolume, IsNegativeForASurfaceTurnedInsideOut) {
  Triangles turned = kTetrahedron;
  for (auto& triangle : turned) std::swap(triangle[0], triangle[1]);
  EXPECT_LT(enclosed_volume_ml(turned, corner(60, {5, 5, 5})), 0);
}

TEST(OpenEdges, AreThoseWithoutExactlyOneOpposite) {
  EXPECT_EQ(open_edges(kTetrahedron), 0U);
  Triangles open = kTetrahedron;
  open.pop_back();
  EXPECT_EQ(open_edges(open), 3U);
  Triangles turned = kTetrahedron;
  std::swap(turned[0][0], turned[0][1]);
  EXPECT_GT(open_edges(turned), 0U);
}

TEST(PinchedVertices, AreWhereTwoBodiesTouchInAPoint) {
  EXPECT_EQ(pinched_vertices(kTetrahedron), 0U);
  // Vertices 0..3 and 0, 4..6: closed everywhere, but no manifold at 0.
  EXPECT_EQ(open_edges(two(0)), 0U);
  EXPECT_EQ(pinched_vertices(two(0)), 1U);
}

TEST(CrossingTriangles, AreThoseThatCutEachOther) {
  const auto both = [](const Vec3f& second_at) {
    std::vector<Vec3f> out = corner(10, {0, 0, 0});
    for (const Vec3f& x : corner(10, second_at)) out.push_back(x);
    return out;
  };
  Triangles apart = kTetrahedron;
  for (auto triangle : kTetrahedron) {
    for (std::uint32_t& vertex : triangle) vertex += 4;
    apart.push_back(triangle);
  }
  EXPECT_EQ(crossing_triangles(kTetrahedron, corner(10, {3, 3, 3})), 0U);
  EXPECT_EQ(crossing_triangles(apart, both({20, 0, 0})), 0U);
  EXPECT_EQ(crossing_triangles(apart, both({7, 7, 7})), 0U) << "boxes overlap, bodies do not";
  EXPECT_GT(crossing_triangles(apart, both({2, 2, 2.5F})), 0U);
  // Far from the origin and across cells alike.
  std::vector<Vec3f> far = both({2, 2, 2.5F});
  for (Vec3f& x : far) x += Vec3f(-500, 300, 77);
  EXPECT_EQ(crossing_triangles(apart, far), crossing_triangles(apart, both({2, 2, 2.5F})));
}

TEST(WrapStep, OfACycleThatDoesNotCloseIsLarge) {
  std::vector<std::vector<Vec3f>> cycle;
  for (int p = 0; p < 8; ++p) {
    const auto angle = static_cast<float>(2.0 * M_PI * p / 8.0);
    cycle.push_back(corner(10, {std::cos(angle), std::sin(angle), 0}));
  }
  EXPECT_NEAR(wrap_step_ratio(cycle), 1.0, 1e-5);
  cycle.resize(5);  // half of a round: back in one step of the diameter
  EXPECT_NEAR(wrap_step_ratio(cycle), 2.0 / (2.0 * std::sin(M_PI / 8.0)), 1e-4);
  EXPECT_EQ(wrap_step_ratio({cycle[0], cycle[0], cycle[0]}), 0.0);
}

/// A sphere of 20 mm that beats by 2 mm, as field, surface and entry of the manifest.
class Sphere : public ::testing::Test {
 protected:
  static constexpr int kPhases = 6;
  static constexpr double kVoxelMm = 2.0;

  static double radius_mm(double share) { return 20.0 + 2.0 * std::cos(2.0 * M_PI * share); }

  Sphere() {
    entry_.name = "heart";
    // An octahedron split four times, put on the sphere.
    std::vector<Vec3> directions{{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                 {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    surface_.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                          {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int round = 0; round < 4; ++round) {
      std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
      const auto middle = [&](std::uint32_t a, std::uint32_t b) {
        const auto [at, added] = middles.try_emplace(std::minmax(a, b), directions.size());
        if (added) directions.push_back((directions[a] + directions[b]).normalized());
        return at->second;
      };
      Triangles finer;
      for (const auto& [a, b, c] : surface_.triangles) {
        const std::uint32_t ab = middle(a, b);
        const std::uint32_t bc = middle(b, c);
        const std::uint32_t ca = middle(c, a);
        finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
      }
      surface_.triangles = finer;
    }
    for (int p = 0; p < kPhases; ++p) {
      const double radius = radius_mm(static_cast<double>(p) / kPhases);
      std::vector<Vec3f>& phase = surface_.positions.emplace_back();
      for (const Vec3& d : directions) phase.push_back((centre_ + radius * d).cast<float>());
      entry_.volume_ml.push_back(4.0 / 3.0 * M_PI * std::pow(radius, 3) * 1e-3);
    }
  }

  [[nodiscard]] field::FieldQuery query(const test::Level& level = {}) const {
    const test::Level sphere = [&](const Vec3& x, double share) {
      return (x - centre_).norm() - radius_mm(share);
    };
    return {
        test::encoded(Structure::Heart, level ? level : sphere, centre_, 36.0, kVoxelMm, kPhases),
        0.8};
  }
  /// The names of the checks that fail.
  [[nodiscard]] std::vector<std::string> failing(const field::FieldQuery& query) const {
    std::vector<std::string> out;
    for (const Check& check : check_one(entry_, &surface_, &query, {})) {
      if (!check.passed()) out.push_back(check.name);
    }
    std::sort(out.begin(), out.end());
    return out;
  }

  const Vec3 centre_{100, 90, 80};
  atlas::StructureEntry entry_;
  atlas::SurfacePayload surface_;
};

using Names = std::vector<std::string>;

TEST_F(Sphere, ThatIsSoundPassesEveryCheckThereIs) {
  const field::FieldQuery sound = query();
  EXPECT_EQ(check_one(entry_, &surface_, &sound, {}).size(), 11U);
  EXPECT_EQ(failing(sound), Names{});
}

TEST_F(Sphere, WithAnIslandOrAHoleIsStray) {
  const auto with = [&](double sign, const Vec3& at) {
    return query([this, sign, at](const Vec3& x, double share) {
      const double sphere = (x - centre_).norm() - radius_mm(share);
      const double other = (x - centre_ - at).norm() - 6.0;
      return sign > 0 ? std::min(sphere, other) : std::max(sphere, -other);
    });
  };
  // 0.9 ml of 34 ml.
  EXPECT_EQ(failing(with(+1.0, Vec3(18, 18, 18))), Names{"stray_percent"});
  EXPECT_EQ(failing(with(-1.0, Vec3(3, 0, 0))), Names{"stray_percent"});
}

TEST_F(Sphere, WhoseFieldIsTwiceTooSteepIsNoDistance) {
  const Names failed = failing(query([&](const Vec3& x, double share) {
    return 2.0 * ((x - centre_).norm() - radius_mm(share));
  }));
  EXPECT_EQ(failed, Names{"slope_error"});
}

TEST_F(Sphere, WhoseSurfaceIsTurnedInsideOutIsOnTheWrongSide) {
  for (auto& triangle : surface_.triangles) std::swap(triangle[0], triangle[1]);
  EXPECT_EQ(failing(query()), (Names{"surface_volume_gap_percent", "wrong_side_percent"}));
}

TEST_F(Sphere, WhoseFieldIsOfAnotherPhaseDoesNotAgreeWithTheSurface) {
  const Names failed = failing(query(
      [&](const Vec3& x, double share) { return (x - centre_).norm() - radius_mm(share + 0.5); }));
  EXPECT_NE(std::find(failed.begin(), failed.end(), "vertex_distance_mm"), failed.end());
}

TEST_F(Sphere, WhoseSurfaceErrorIsThatOfItsTriangles) {
  const field::FieldQuery sound = query();
  // Edges of 2.3 mm cut e^2 / 6 r = 0.04 mm off a sphere of 20 mm in their middle.
  const double before = surface_error_mm(sound, surface_);
  EXPECT_NEAR(before, 0.04, 0.03);
  for (auto& phase : surface_.positions) {
    for (Vec3f& x : phase) {
      const Vec3 way = (x.cast<double>() - centre_).normalized();
      x += (0.5 * way).cast<float>();
    }
  }
  EXPECT_NEAR(surface_error_mm(sound, surface_), 0.5 - before, 0.03);
  EXPECT_EQ(failing(sound), Names{"surface_error_mm"});
}

TEST_F(Sphere, WithASurfaceThatPassesThroughItselfCrosses) {
  // In one phase every second vertex lies on the other side: nothing of the shape is left.
  for (std::size_t n = 0; n < surface_.positions[2].size(); n += 2) {
    Vec3f& x = surface_.positions[2][n];
    x = (2.0 * centre_ - x.cast<double>()).cast<float>();
  }
  const Names failed = failing(query());
  EXPECT_NE(std::find(failed.begin(), failed.end(), "crossing_percent"), failed.end());
}

TEST_F(Sphere, WhoseCurveIsAnotherHasAVolumeGap) {
  for (double& ml : entry_.volume_ml) ml *= 1.4;
  EXPECT_EQ(failing(query()), (Names{"field_volume_gap_percent", "surface_volume_gap_percent"}));
  entry_.volume_ml.pop_back();
  EXPECT_EQ(failing(query()), (Names{"field_volume_gap_percent", "surface_volume_gap_percent"}));
}

TEST(CrossingTriangles, OfTwoSurfacesAreThoseThatCutEachOther) {
  const std::vector<Vec3f> large = corner(60, {0, 0, 0});
  EXPECT_EQ(crossing_triangles(kTetrahedron, large, kTetrahedron, corner(10, {5, 5, 5})), 0U);
  EXPECT_EQ(crossing_triangles(kTetrahedron, large, kTetrahedron, corner(10, {80, 5, 5})), 0U);
  // A small corner half in: its edges along x pass through the face at x = 0.
  const std::size_t cut =
      crossing_triangles(kTetrahedron, large, kTetrahedron, corner(10, {-5, 5, 5}));
  EXPECT_GE(cut, 3U);
  EXPECT_EQ(crossing_triangles(kTetrahedron, corner(10, {-5, 5, 5}), kTetrahedron, large), cut);
}

TEST(ManifestChecks, ContentIsWhatTheSceneHolds) {
  atlas::Manifest manifest;
  manifest.scene = "palpation";
  manifest.structures = {{"heart", {100, 80, 60, 90}}, {"lv_blood", {50, 30, 20, 40}}};
  manifest.end_diastole = 0;
  manifest.end_systole = 2;
  manifest.items = {{"", "field", "heart", 0, ""},
                    {"", "surface", "lv_blood", 0, ""},
                    {"", "motion", "lv_blood", 0, ""}};
  const auto worst = [&](std::size_t check) { return check_manifest(manifest).at(check).worst; };
  EXPECT_EQ(worst(0), 0);
  EXPECT_EQ(worst(1), 0);
  manifest.items.push_back({"", "surface", "heart", 0, ""});
  EXPECT_EQ(worst(0), 1);
  manifest.items.resize(1);
  EXPECT_EQ(worst(0), 2);
  manifest.format_version = 3;  // which held the field alone
  EXPECT_EQ(worst(0), 0);
  manifest.items.clear();
  EXPECT_EQ(worst(0), 1);
  manifest.end_systole = 1;
  EXPECT_EQ(worst(1), 1);
  manifest.end_diastole = 9;
  EXPECT_EQ(worst(1), 2);
}

TEST(ManifestChecks, WhatTheSceneNeedsIsThereInEveryPhase) {
  atlas::Manifest manifest;
  manifest.frame_times_s = {0, 0.2, 0.4, 0.6};
  manifest.structures = {{"heart", {100, 80, 60, 90}}, {"rv_blood", {50, 0, 20, 0}}};
  const auto missing = [&] {
    std::map<std::string, double> out;
    for (const Check& check : check_manifest(manifest)) {
      if (check.name == "missing_phases") out[check.structure] = check.worst;
    }
    return out;
  };
  EXPECT_TRUE(missing().empty()) << "a package that tells no needs";
  manifest.provenance = {{"needs", {"heart", "lv_blood", "rv_blood"}}};
  EXPECT_EQ(missing(),
            (std::map<std::string, double>{{"heart", 0}, {"lv_blood", 4}, {"rv_blood", 2}}));
  const std::vector<std::string> failures = failures_of(check_manifest(manifest));
  EXPECT_EQ(std::count_if(failures.begin(), failures.end(),
                          [](const std::string& said) {
                            return said.starts_with("lv_blood: its scene needs it");
                          }),
            1);
}

TEST(ManifestChecks, AnEjectionFractionIsOneOfALivingHeart) {
  atlas::Manifest manifest;
  const auto beyond = [&](std::vector<double> volume_ml) {
    manifest.structures = {{"lv_blood", std::move(volume_ml)}};
    const std::vector<Check> checks = check_manifest(manifest);
    EXPECT_EQ(checks.back().name, "impossible_ef_points");
    return checks.back().worst;
  };
  EXPECT_EQ(beyond({100, 40}), 0);
  EXPECT_EQ(beyond({100, 95}), 0);
  EXPECT_NEAR(beyond({100, 97}), 2, 1e-9);
  EXPECT_NEAR(beyond({100, 4}), 6, 1e-9);
  EXPECT_NEAR(beyond({50, 50}), 5, 1e-9);
  EXPECT_EQ(check_manifest({}).back().name, "end_phases") << "no LV, no ejection fraction";
}

}  // namespace
}  // namespace beatlas::assess
