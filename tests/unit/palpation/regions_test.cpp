#include "runtime/palpation/regions.h"

#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/palpation/measured.h"
#include "runtime/palpation/parameters.h"
#include "tests/unit/palpation/sample_wall.h"

namespace beatlas::palpation {
namespace {

using nlohmann::json;

std::string refusal(const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return "accepted";
}

TEST(LvWall, FindsTheMuscleUnderAPlaceAtAnyMoment) {
  const test::SampleWall sample;
  const LvWall wall = sample.wall();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::uint32_t from = 0;
  for (int n = 0; n < 300; ++n) {
    const Vec3 unit = Vec3(normal(random), normal(random), normal(random)).normalized();
    if (unit.z() > 0.85) continue;  // there is no wall
    const double beats = 0.25 * (n % 4) + n;
    const double radius = n % 4 == 0 ? 25 : n % 4 == 2 ? 20 : 22.5;
    const WallPlace place = wall.nearest(38 * unit, beats);
    // Up to 2 mm beside it.
    EXPECT_NEAR(place.away_mm, 38 - radius, 0.25);
    EXPECT_NEAR(place.long_axis, 0.5 + 0.5 * unit.z(), 0.06);
    EXPECT_EQ(place.segment, sample.map->segment[place.vertex]);
    EXPECT_EQ(place.wall_mm, sample.map->thickness_mm[0][place.vertex]);
    // Downhill from wherever the last place was.
    const WallPlace near = wall.near(38 * unit, beats, from);
    EXPECT_NEAR(near.away_mm, place.away_mm, 1e-9);
    EXPECT_EQ(near.vertex, place.vertex);
    from = near.vertex;
  }
}

TEST(LvWall, SharesAreThoseOfTheMuscle) {
  const test::SampleWall sample;
  const LvWall wall = sample.wall();
  const std::vector<double>& share = wall.muscle_share();
  EXPECT_NEAR(std::accumulate(share.begin(), share.end(), 0.0), 1, 1e-12);
  double thin = 0;
  for (std::size_t v = 0; v < share.size(); ++v) thin += wall.wall_mm()[v] == 4 ? share[v] : 0;
  EXPECT_NEAR(thin, 4.0 / 14, 0.025);  // half of the ball less one line of vertices
}

TEST(LvWall, KnowsTheMiddleOfASegment) {
  const test::SampleWall sample;
  const LvWall wall = sample.wall();
  for (const int segment : {7, 10, 12, 14}) {
    const std::uint32_t middle = wall.middle_of(segment);
    EXPECT_EQ(sample.map->segment[middle], segment);
    EXPECT_GT(wall.outward(middle).dot(wall.mm(middle).normalized()), 0.99);
  }
  // Mid anterior: thirds of the long axis, towards x.
  EXPECT_LT((wall.mm(wall.middle_of(7)) - Vec3(25, 0, 0)).norm(), 2.5);
  EXPECT_NE(refusal([&] { (void)wall.middle_of(99); }).find("no segment 99"), std::string::npos);
}

// What lies over the muscle at any time is followed back to end-diastole, between vertices and
// between phases: the sample's muscle moves along its radius.
TEST(LvWall, FollowsMaterialBackToEndDiastole) {
  const int phases = 16;
  const test::SampleWall sample(phases);
  const LvWall wall = sample.wall();
  double worst_mm = 0;
  for (int n = 0; n < 200; ++n) {
    const double z = -0.85 + 1.6 * n / 200;
    const double angle = 2.4 * n;
    const double across = std::sqrt(1 - z * z);
    const Vec3 unit(across * std::cos(angle), across * std::sin(angle), z);
    const double beats = 0.037 * n;
    const double beat = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * beats);
    const Vec3 outside = (test::kRadiusMm - 5 * beat + 8) * unit;
    const LvWall::Material found = wall.material_at(outside, beats);
    worst_mm = std::max(worst_mm, (found.mm - test::kRadiusMm * unit).norm());
    EXPECT_LT((wall.mm(found.vertex) - found.mm).norm(), 2.5);
  }
  // The ball's edges are up to 3.3 mm long: from 8 mm outside a plane's nearest point lies up to
  // half an edge's angle, 0.066, aside.
  EXPECT_LT(worst_mm, 0.55);
}

TEST(LvWall, OfOtherThingsIsRefused) {
  const test::SampleWall sample;
  const test::SampleWall other(4, 2);
  EXPECT_NE(refusal([&] { (void)LvWall(sample.surface, nullptr, 0); }).find("no map"),
            std::string::npos);
  EXPECT_NE(refusal([&] { (void)LvWall(sample.surface, other.map, 0); }), "accepted");
  EXPECT_NE(refusal([&] { (void)LvWall(sample.surface, sample.map, 4); }), "accepted");
  for (auto& phase : other.map->thickness_mm) std::fill(phase.begin(), phase.end(), 0.0F);
  EXPECT_NE(refusal([&] { (void)LvWall(other.surface, other.map, 0); }).find("no wall"),
            std::string::npos);
}

TEST(Regions, OfThinWallHaveItsShareOfTheMuscleAndItsOwnThickness) {
  const test::SampleWall sample;
  const LvWall wall = sample.wall();
  const std::vector<Region> regions =
      regions_from_json(parse_json(R"([{"thinner_than_mm": 6, "scar": 0.8, "alpha": 0.2}])"));
  const TissueMap map = tissue_of_wall(wall, {}, regions, {});
  EXPECT_NEAR(map.infarct.fraction, 4.0 / 14, 0.025);
  EXPECT_NEAR(map.infarct.alpha, 0.2, 1e-12);
  const Tissue thin = map.at(wall.nearest({30, 0, 0}, 0));
  EXPECT_EQ(thin, (Tissue{.scar = 0.8, .thickness_ratio = 0.4, .alpha = 0.2}));  // 4 of 10 mm
  EXPECT_EQ(map.at(wall.nearest({-30, 0, 0}, 0)), Tissue{});
  EXPECT_EQ(tissue_of_wall(wall, {}, {}, {}).infarct.fraction, 0);
  // No wall is not a thin one.
  EXPECT_EQ(map.of_vertex[4], Tissue{});
  ASSERT_EQ(sample.map->thickness_mm[0][4], 0);
}

TEST(Regions, LieOverTheSegmentsTheLastOnTop) {
  const test::SampleWall sample;
  const LvWall wall = sample.wall();
  SegmentTissue segments{};
  segments[6] = infarct_tissue();  // mid anterior
  RegionMaps maps;
  maps.painted["scar.csv"].assign(wall.vertex_count(), 0);
  const WallPlace inferior = wall.nearest({-30, 0, 0}, 0);
  maps.painted["scar.csv"][inferior.vertex] = 3;
  const WallPlace anterior = wall.nearest({30, 0, 0}, 0);
  EXPECT_EQ(tissue_of_wall(wall, segments, {}, {}).at(anterior), infarct_tissue());
  const std::vector<Region> regions = regions_from_json(parse_json(
      R"([{"painted": "scar.csv", "label": 3, "scar": 0.5, "thickness_ratio": 1.2, "alpha": 0.7},
          {"thinner_than_mm": 5, "scar": 0.1}])"));
  const TissueMap map = tissue_of_wall(wall, segments, regions, maps);
  EXPECT_EQ(map.at(inferior), (Tissue{.scar = 0.5, .thickness_ratio = 1.2, .alpha = 0.7}));
  EXPECT_EQ(map.at(anterior).scar, 0.1);
  EXPECT_EQ(map.at(anterior).alpha, 1);
  EXPECT_NEAR(map.infarct.fraction, wall.muscle_share()[inferior.vertex], 1e-12);
  EXPECT_NE(refusal([&] { (void)tissue_of_wall(wall, segments, regions, {}); }).find("scar.csv"),
            std::string::npos);
}

TEST(Measured, PointsTellOfTheMuscleAboutThem) {
  const test::SampleWall sample;
  const LvWall wall = sample.wall();
  // In the middle of 4 mm of wall on the right, of 10 mm on the left.
  const std::vector<MeasuredPoint> points{{.mm = {test::kRadiusMm + 2, 0, 0}, .kpa = 30},
                                          {.mm = {-test::kRadiusMm - 5, 0, 0}, .kpa = 6}};
  const std::vector<float> kpa = kpa_of_wall(wall, points, 12);
  EXPECT_FLOAT_EQ(kpa[wall.nearest({40, 0, 0}, 0).vertex], 30);
  EXPECT_FLOAT_EQ(kpa[wall.nearest({-40, 0, 0}, 0).vertex], 6);
  EXPECT_EQ(kpa[wall.nearest({0, 40, 0}, 0).vertex], 0);  // out of reach
  int reached = 0;
  for (std::uint32_t v = 0; v < wall.vertex_count(); ++v) {
    const double thick = static_cast<double>(wall.wall_mm()[v]);
    const Vec3 middle = wall.mm(v) + 0.5 * thick * wall.outward(v);
    const bool near =
        thick > 0 && ((middle - points[0].mm).norm() <= 12 || (middle - points[1].mm).norm() <= 12);
    EXPECT_EQ(kpa[v] > 0, near) << v;
    reached += near ? 1 : 0;
  }
  EXPECT_GT(reached, 20);
  // Half-way between two points both count alike.
  const double half = 0.2;
  const auto at = [](double angle) {
    return Vec3((test::kRadiusMm + 5) * Vec3(-std::cos(angle), std::sin(angle), 0));
  };
  const std::vector<float> two =
      kpa_of_wall(wall, {{.mm = at(half), .kpa = 10}, {.mm = at(-half), .kpa = 20}}, 20);
  EXPECT_NEAR(two[wall.nearest({-40, 0, 0}, 0).vertex], 15, 0.8);
}

TEST(Measured, OfAnotherHeartIsRefusedByThePoint) {
  const test::SampleWall sample;
  const LvWall wall = sample.wall();
  const std::vector<MeasuredPoint> points{{.mm = {test::kRadiusMm + 2, 0, 0}, .kpa = 30},
                                          {.mm = {0, 0, -test::kRadiusMm - 45}, .kpa = 6}};
  EXPECT_NE(refusal([&] { (void)kpa_of_wall(wall, points, 10); }).find("point 2 lies 40 mm"),
            std::string::npos);
}

TEST(Regions, OfMeasuredStiffnessSetThatAlone) {
  const test::SampleWall sample;
  const LvWall wall = sample.wall();
  const WallPlace stiff = wall.nearest({30, 0, 0}, 0);
  const WallPlace soft = wall.nearest({-30, 0, 0}, 0);
  RegionMaps maps;
  maps.measured["e.csv"].assign(wall.vertex_count(), 0);
  maps.measured["e.csv"][stiff.vertex] = 30;
  maps.measured["e.csv"][soft.vertex] = 5;
  const TissueMap map = tissue_of_wall(wall, {},
                                       regions_from_json(parse_json(
                                           R"([{"thinner_than_mm": 6, "scar": 1, "alpha": 0.2},
              {"measured": "e.csv", "healthy_kpa": 10}])")),
                                       maps);
  // The scar's own 1.53 is in what was measured.
  EXPECT_EQ(map.at(stiff),
            (Tissue{.scar = 1, .thickness_ratio = 0.4, .alpha = 0.2, .stiffness_ratio = 3 / 1.53}));
  EXPECT_EQ(map.at(soft), (Tissue{.stiffness_ratio = 0.5}));
  EXPECT_EQ(map.at(wall.nearest({0, -30, 0}, 0)).stiffness_ratio, 1);
  // Felt, too.
  const MuscleConstants healthy = MuscleTable().middle;
  EXPECT_NEAR(in_tissue(healthy, map.at(soft)).k_v_n_per_m, 0.5 * healthy.k_v_n_per_m, 1e-9);

  // Without a healthy stiffness the median of what was measured is.
  const auto regions = regions_from_json(parse_json(R"([{"measured": "e.csv"}])"));
  maps.measured["e.csv"].assign(wall.vertex_count(), 8);
  maps.measured["e.csv"][stiff.vertex] = 24;
  EXPECT_NEAR(tissue_of_wall(wall, {}, regions, maps).at(stiff).stiffness_ratio, 3, 1e-12);
  maps.measured["e.csv"][stiff.vertex] = 240;
  EXPECT_NE(refusal([&] { (void)tissue_of_wall(wall, {}, regions, maps); }).find("240 kPa"),
            std::string::npos);
  maps.measured["e.csv"].assign(wall.vertex_count(), 0);
  EXPECT_NE(refusal([&] { (void)tissue_of_wall(wall, {}, regions, maps); }).find("says nothing"),
            std::string::npos);
  EXPECT_NE(refusal([&] { (void)tissue_of_wall(wall, {}, regions, {}); }).find("e.csv"),
            std::string::npos);
}

TEST(Regions, AreRefusedByJsonPath) {
  const auto said = [](const char* regions) {
    return refusal([&] {
      (void)palpation_from_json(parse_json(std::string(R"({"regions": )") + regions + "}"));
    });
  };
  EXPECT_EQ(said(R"([{"thinner_than_mm": 6}, {"painted": "a.csv"}])"), "accepted");
  EXPECT_NE(said("{}").find("/regions must be a list"), std::string::npos);
  EXPECT_NE(said(R"([{"scar": 1}])").find("/regions/0 must have one of"), std::string::npos);
  EXPECT_NE(said(R"([{"thinner_than_mm": 6, "painted": "a"}])").find("/regions/0 must have"),
            std::string::npos);
  EXPECT_EQ(said(R"([{"measured": "e.csv", "healthy_kpa": 12, "reach_mm": 5}])"), "accepted");
  EXPECT_NE(said(R"([{"measured": "e.csv", "painted": "a"}])").find("/regions/0 must have one of"),
            std::string::npos);
  EXPECT_NE(said(R"([{"painted": "a", "healthy_kpa": 12}])").find("/regions/0/healthy_kpa"),
            std::string::npos);
  EXPECT_NE(said(R"([{"measured": "e.csv", "scar": 1}])").find("/regions/0/scar is not measured"),
            std::string::npos);
  EXPECT_NE(said(R"([{"thinner_than_mm": 60}])").find("/regions/0/thinner_than_mm"),
            std::string::npos);
  EXPECT_NE(said(R"([{"thinner_than_mm": 6, "label": 2}])").find("/regions/0/label"),
            std::string::npos);
  EXPECT_NE(said(R"([{"thinner_than_mm": 6, "alpha": 2}])").find("/regions/0/alpha"),
            std::string::npos);
  EXPECT_NE(said(R"([{"thinner_than_mm": 6, "colour": 2}])").find("/regions/0/colour"),
            std::string::npos);
  const std::vector<Region> regions = regions_from_json(parse_json(
      R"([{"painted": "b.csv", "label": 7, "thickness_ratio": 0.5}, {"thinner_than_mm": 6},
          {"measured": "e.csv", "reach_mm": 4}, {"measured": "f.csv", "healthy_kpa": 9}])"));
  EXPECT_EQ(regions_from_json(regions_to_json(regions)), regions);
}

TEST(Regions, MakeTheInfarctOfTheCirculation) {
  PalpationParameters parameters;
  parameters.infarct = Infarct{.fraction = 0.3, .alpha = 0.25};
  EXPECT_EQ(parameters.whole_circulation().infarct_fraction, 0.3);
  EXPECT_EQ(parameters.whole_circulation().infarct_alpha, 0.25);
}

TEST(LvWall, FollowsAFingerFromAnywhereToTheNearestWall) {
  const LvWall wall = test::SampleWall().wall();
  const auto calls = static_cast<int>(wall.vertex_count() / 32 + 2);
  LvWall::Trail trail;
  for (const Vec3& at : {Vec3(40, 3, -8), Vec3(-30, 12, 4), Vec3(2, -3, 45), Vec3(0, 0, -40)}) {
    for (int n = 0; n < calls; ++n) (void)wall.follow(at, 0.3, trail);
    const WallPlace found = wall.follow(at, 0.3, trail);
    const WallPlace nearest = wall.nearest(at, 0.3);
    EXPECT_EQ(found.vertex, nearest.vertex) << at.transpose();
    EXPECT_GT(found.wall_mm, 0);  // over the base, too, whose flat end has none
    // From then on a finger of 100 mm/s is followed at once.
    for (int n = 0; n < 200; ++n) {
      const Vec3 moved = at + 0.1 * n * Vec3(0.6, 0.8, 0);
      EXPECT_NEAR(wall.follow(moved, 0.3, trail).away_mm, wall.nearest(moved, 0.3).away_mm, 0.2);
    }
  }
}

}  // namespace
}  // namespace beatlas::palpation
