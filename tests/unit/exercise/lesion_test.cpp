#include "runtime/exercise/lesion.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/palpation/sample_wall.h"

namespace beatlas::exercise {
namespace {

using palpation::test::SampleWall;

/// The ball's half at positive x can be touched.
struct Half {
  SampleWall sample;
  palpation::LvWall wall = sample.wall();
  Ground ground{.wall = wall, .touchable = {}};
  Half() {
    for (std::uint32_t v = 0; v < wall.vertex_count(); ++v) {
      ground.touchable.push_back(wall.wall_mm()[v] > 0 && wall.mm(v).x() > 0);
    }
  }
};

TEST(Lesion, IsDrawnWhereItCanBeFelt) {
  const Half half;
  Exercise asked;
  asked.lesions = 2;
  asked.radius_mm = {4, 8};
  std::set<std::uint32_t> middles;
  std::set<LesionKind> kinds;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const std::vector<Lesion> drawn = draw_lesions(asked, half.ground, seed);
    ASSERT_EQ(drawn.size(), 2U);
    for (const Lesion& lesion : drawn) {
      EXPECT_TRUE(half.ground.touchable[lesion.vertex]);
      EXPECT_GE(lesion.grade, asked.grade.low);
      EXPECT_LE(lesion.grade, asked.grade.high);
      EXPECT_GE(lesion.radius_mm, 4);
      EXPECT_LE(lesion.radius_mm, 8);
      middles.insert(lesion.vertex);
      kinds.insert(lesion.kind);
    }
    EXPECT_GT((half.wall.mm(drawn[0].vertex) - half.wall.mm(drawn[1].vertex)).norm(),
              drawn[0].radius_mm + drawn[1].radius_mm);
    const std::vector<Lesion> again = draw_lesions(asked, half.ground, seed);
    EXPECT_EQ(again[1].vertex, drawn[1].vertex);
    EXPECT_EQ(again[1].grade, drawn[1].grade);
  }
  EXPECT_GT(middles.size(), 60U);  // spread, not at favourite places
  EXPECT_EQ(kinds.size(), 4U);
}

TEST(Lesion, KeepsToItsSegments) {
  const Half half;
  Exercise asked;
  asked.segments = {7};
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    EXPECT_EQ(half.sample.map->segment[draw_lesions(asked, half.ground, seed)[0].vertex], 7);
  }
  asked.segments = {10};  // the other side
  std::string told;
  try {
    (void)draw_lesions(asked, half.ground, 1);
  } catch (const Error& error) {
    told = error.what();
  }
  EXPECT_NE(told.find("can reach none of the exercise's segments"), std::string::npos) << told;
  Exercise many;
  many.lesions = 3;
  many.radius_mm = {30, 30};
  EXPECT_THROW((void)draw_lesions(many, half.ground, 1), Error);
}

TEST(Lesion, IsWholeInItsMiddleHalfAtItsRadiusAndNoneBeyond) {
  const Half half;
  palpation::TissueMap tissue;
  tissue.of_vertex.resize(half.wall.vertex_count());
  const std::uint32_t middle = half.wall.middle_of(7);
  hide_lesions({{.kind = LesionKind::Soft, .grade = 0.6, .radius_mm = 10, .vertex = middle}},
               half.wall, tissue);
  EXPECT_NEAR(tissue.of_vertex[middle].stiffness_ratio, 0.4, 1e-12);
  for (std::uint32_t v = 0; v < half.wall.vertex_count(); ++v) {
    const double away = (half.wall.mm(v) - half.wall.mm(middle)).norm();
    const double ratio = tissue.of_vertex[v].stiffness_ratio;
    if (away <= 7.5) {
      EXPECT_NEAR(ratio, 0.4, 1e-12) << away;
    }
    if (away >= 12.5) {
      EXPECT_EQ(ratio, 1) << away;
    }
    if (std::abs(away - 10) < 0.1) {
      EXPECT_NEAR(ratio, 0.7, 0.03) << away;
    }
  }
  EXPECT_EQ(tissue.infarct.fraction, 0);  // soft muscle contracts
}

TEST(Lesion, EachKindIsFeltInItsOwnWay) {
  const palpation::Tissue healthy;
  const palpation::Tissue soft = with_lesion(healthy, LesionKind::Soft, 0.5);
  const palpation::Tissue thin = with_lesion(healthy, LesionKind::Thin, 0.5);
  const palpation::Tissue akinetic = with_lesion(healthy, LesionKind::Akinetic, 0.5);
  const palpation::Tissue scar = with_lesion(healthy, LesionKind::Scar, 0.5);
  const auto rest = [](const palpation::Tissue& tissue) {
    return palpation::in_tissue(palpation::MuscleTable().middle, tissue).k_v_n_per_m;
  };
  EXPECT_LT(rest(soft), rest(healthy));
  EXPECT_LT(rest(thin), rest(healthy));
  EXPECT_EQ(rest(akinetic), rest(healthy));
  EXPECT_GT(rest(scar), rest(healthy));
  EXPECT_EQ(soft.alpha, 1);
  EXPECT_EQ(thin.alpha, 0.5);
  EXPECT_EQ(akinetic.alpha, 0.5);
  EXPECT_EQ(scar.alpha, 0.5);
  // What was ill before stays so.
  EXPECT_NEAR(with_lesion(akinetic, LesionKind::Thin, 0.5).alpha, 0.25, 1e-12);
}

TEST(Lesion, OfADifferenceHasThatDifferenceUnderTheFinger) {
  const Half half;
  palpation::TissueMap tissue;
  tissue.of_vertex.resize(half.wall.vertex_count());
  const palpation::PalpationParameters parameters;
  const auto wall = std::make_shared<palpation::LvWall>(half.sample.wall());
  const palpation::AtlasMuscle healthy(wall, tissue, parameters);
  const std::uint32_t middle = half.wall.middle_of(7);
  const auto stiffness = [&](const palpation::AtlasMuscle& muscle) {
    const palpation::PatchConstants& here = muscle.as_it_is(middle);
    return here.k_v_n_per_m + here.k_e_rest_n_per_m + muscle.natural().pressure_at(0);
  };
  for (const double difference : {0.02, 0.1, 0.25}) {
    const Lesion lesion = lesion_of_difference(difference, 12, middle, healthy);
    EXPECT_NEAR(difference_of_lesion(lesion, healthy), difference, 1e-12);
    palpation::TissueMap ill = tissue;
    hide_lesions({lesion}, half.wall, ill);
    const palpation::AtlasMuscle muscle(wall, ill, parameters);
    EXPECT_NEAR(stiffness(muscle) / stiffness(healthy), 1 - difference, 1e-9) << difference;
  }
  // More than the muscle's own share cannot be missing.
  const Lesion most = lesion_of_difference(0.9, 12, middle, healthy);
  EXPECT_EQ(most.grade, 0.9);
  EXPECT_LT(difference_of_lesion(most, healthy), 0.6);
}

TEST(ThresholdPlaces, LieApartWhereAFingerGets) {
  const Half half;
  Exercise asked;
  asked.task = Task::Threshold;
  asked.radius_mm = {6, 6};
  const std::vector<std::uint32_t> places = threshold_places(asked, half.ground);
  ASSERT_EQ(places.size(), 4U);
  for (std::size_t a = 0; a < 4; ++a) {
    EXPECT_TRUE(half.ground.touchable[places[a]]);
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_GE((half.wall.mm(places[a]) - half.wall.mm(places[b])).norm(), 12);
    }
  }
  asked.radius_mm = {30, 30};
  EXPECT_THROW((void)threshold_places(asked, half.ground), Error);
}

}  // namespace
}  // namespace beatlas::exercise
