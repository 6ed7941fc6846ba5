#include "pipeline/build/quality.h"

#include <cmath>

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::build {
namespace {

const std::vector<std::array<std::uint32_t, 3>> kTetrahedron{
    {0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

/// Corner of a cube of edge `edge_mm` anywhere: edge^3 / 6.
std::vector<Vec3f> corner(float edge_mm, const Vec3f& at) {
  return {at, at + Vec3f(edge_mm, 0, 0), at + Vec3f(0, edge_mm, 0), at + Vec3f(0, 0, edge_mm)};
}

FieldCycle field_of(std::vector<double> volume_ml) {
  FieldCycle field;
  field.structure = Structure::LvBlood;
  field.volume_ml = std::move(volume_ml);
  return field;
}

TEST(Quality, IsTheLargestGapAsAShareOfTheLargestVolume) {
  const std::vector<report::VolumeCurve> segmented{{Structure::LvBlood, {100, 36}}};
  SurfaceCycle surface{Structure::LvBlood, kTetrahedron, {}};
  surface.positions = {corner(60, {0, 0, 0}), corner(60, {0, 0, 0})};  // 36 ml and 36 ml
  const auto quality = measure_quality(segmented, {field_of({98, 39})}, {surface});
  ASSERT_EQ(quality.size(), 1U);
  EXPECT_NEAR(quality[0].field_volume_excess_percent, 3, 1e-12);
  EXPECT_NEAR(quality[0].surface_volume_excess_percent, -64, 1e-3);
  EXPECT_EQ(quality[0].field_phase, 1);
  EXPECT_EQ(quality[0].surface_phase, 0);
}

TEST(Quality, BelowTheDemandItIsRefusedWithFigureAndLimit) {
  const auto quality = measure_quality({{Structure::LvBlood, {100}}}, {field_of({93})}, {});
  QualityOptions options;
  options.max_volume_gap_percent = 7.1;
  EXPECT_NO_THROW(demand_quality(quality, options));
  options.max_volume_gap_percent = 6.9;
  try {
    demand_quality(quality, options);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Quality);
    EXPECT_NE(std::string(error.what()).find("lv_blood"), std::string::npos);
    EXPECT_NE(std::string(error.what())
                  .find("7.0 % of its largest volume in the beat too little in phase 0"),
              std::string::npos)
        << error.what();
  }
}

TEST(Quality, AnEmptySegmentationDoesNotPass) {
  const auto quality = measure_quality({{Structure::LvBlood, {0}}}, {field_of({0})}, {});
  EXPECT_THROW(demand_quality(quality, {}), Error);
}

TEST(Quality, OtherPhasesOrStructuresAreRefused) {
  EXPECT_THROW((void)measure_quality({{Structure::LvBlood, {1, 2}}}, {field_of({1})}, {}), Error);
  EXPECT_THROW((void)measure_quality({{Structure::Heart, {1}}}, {field_of({1})}, {}), Error);
}

}  // namespace
}  // namespace beatlas::build
