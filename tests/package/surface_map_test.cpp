/// Maps of the LV's wall through the package: each value stays with its vertex, within the stated
/// error.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/atlas.h"
#include "runtime/atlas/surface_map_payload.h"
#include "runtime/base/error.h"
#include "tests/package/sample_package.h"

namespace beatlas {
namespace {

using atlas::SurfaceMapPayload;
constexpr double kTurn = 2 * std::numbers::pi;

double around(double from, double to) { return std::abs(std::remainder(from - to, kTurn)); }

atlas::Atlas written(const pack::PackageContent& content, const test::TemporaryFolder& folder) {
  const auto file = folder.path() / "a.beatlas";
  pack::write_package(file, content);
  return atlas::Atlas::open(file, atlas::everything_in(atlas::Atlas::open(file, {}).manifest()));
}

std::string refusal(const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return {};
}

/// A value of a vertex is a function of its place here, and the place is read from the surface:
/// an order that differs from the surface's would show, whatever the encoder believes.
TEST(SurfaceMapInAPackage, BelongsToTheVerticesOfItsSurfaceWithinTheStatedErrors) {
  const test::TemporaryFolder folder;
  const atlas::Atlas opened = written(test::sample_content(7, 22, 1.5, 4), folder);
  const auto surface = opened.surface(Structure::LvBlood);
  const auto map = opened.surface_map(Structure::LvBlood);
  ASSERT_NE(map, nullptr);
  EXPECT_EQ(opened.surface_map(Structure::LvMyocardium), nullptr);
  ASSERT_EQ(map->segment.size(), surface->positions[0].size());
  ASSERT_EQ(map->thickness_mm.size(), 7U);
  const Vec3 centre(128, 128, 96);
  // A vertex lies within 0.01 mm of where it was, 13 mm from the centre.
  constexpr double kOfPlace = 0.01 / 10;
  double worst_mm = 0;
  int none = 0;
  for (std::size_t v = 0; v < map->segment.size(); ++v) {
    const Vec3 unit = (surface->positions[0][v].cast<double>() - centre).normalized();
    EXPECT_NEAR(map->long_axis[v], 0.5 + 0.5 * unit.z(), atlas::kMaxLongAxisError + kOfPlace);
    const double off_axis = std::hypot(unit.x(), unit.y());
    if (off_axis > 0.05) {
      EXPECT_LE(around(map->angle_rad[v], std::atan2(unit.y(), unit.x())),
                atlas::kMaxAngleErrorRad + kOfPlace / off_axis);
    }
    if (map->thickness_mm[0][v] == 0) {
      ++none;
      continue;
    }
    for (std::size_t p = 0; p < 7; ++p) {
      const double beat = 0.5 - 0.5 * std::cos(kTurn * static_cast<double>(p) / 7);
      const double wall_mm = (8.2 + unit.y()) * (1 + 0.4 * beat);
      worst_mm = std::max(worst_mm, std::abs(map->thickness_mm[p][v] - wall_mm));
    }
  }
  EXPECT_LE(worst_mm, atlas::kMaxThicknessErrorMm + 2 * kOfPlace);
  EXPECT_GT(worst_mm, 0.4 * atlas::kThicknessStepMm);  // it is quantised, so this can fail
  EXPECT_NEAR(none, static_cast<double>(map->segment.size()) / 16, 1);
}

TEST(SurfaceMapInAPackage, IsStoredInTheOrderThatPackingTold) {
  const atlas::SurfacePayload surface = test::beating_surface(Structure::LvBlood, 15, 2, 5, 3);
  const SurfaceMapPayload map = test::beating_map(surface);
  const std::vector<std::uint32_t> given = pack::pack_surface(surface).given;
  const SurfaceMapPayload found =
      atlas::decode_surface_map(pack::pack_surface_map(map, given), Structure::LvBlood);
  double angle_error = 0;
  double place_error = 0;
  double thickness_error_mm = 0;
  for (std::size_t v = 0; v < given.size(); ++v) {
    EXPECT_EQ(found.segment[v], map.segment[given[v]]);
    angle_error = std::max(angle_error, around(found.angle_rad[v], map.angle_rad[given[v]]));
    place_error =
        std::max(place_error, double(std::abs(found.long_axis[v] - map.long_axis[given[v]])));
    for (std::size_t p = 0; p < 5; ++p) {
      const float was = map.thickness_mm[p][given[v]];
      EXPECT_EQ(found.thickness_mm[p][v] == 0, was == 0);
      thickness_error_mm =
          std::max(thickness_error_mm, double(std::abs(found.thickness_mm[p][v] - was)));
    }
  }
  EXPECT_LE(angle_error, atlas::kMaxAngleErrorRad + 1e-6);
  EXPECT_LE(place_error, atlas::kMaxLongAxisError + 1e-7);
  EXPECT_LE(thickness_error_mm, atlas::kMaxThicknessErrorMm + 1e-6);
  EXPECT_GT(place_error, 0.5 * atlas::kMaxLongAxisError);
}

TEST(SurfaceMapInAPackage, KeepsTheThinnestWallAndTheEndsOfEveryRange) {
  SurfaceMapPayload map{Structure::LvBlood,
                        {0, 1, 0.5F},
                        {0, 6.2831853F, 3.1415927F},
                        {1, 17, 9},
                        {{0.001F, 0, 100}, {100, 0.03F, 0}}};
  const SurfaceMapPayload found =
      atlas::decode_surface_map(pack::pack_surface_map(map, {2, 0, 1}), Structure::LvBlood);
  EXPECT_EQ(found.segment, (std::vector<std::uint8_t>{9, 1, 17}));
  EXPECT_EQ(found.long_axis, (std::vector<float>{0.5F, 0, 1}));
  EXPECT_EQ(found.angle_rad[2], 0);  // a whole turn
  EXPECT_FLOAT_EQ(found.thickness_mm[0][0], 100);
  EXPECT_FLOAT_EQ(found.thickness_mm[0][1], 0.05F);
  EXPECT_EQ(found.thickness_mm[1][0], 0);
  EXPECT_FLOAT_EQ(found.thickness_mm[1][2], 0.05F);
}

TEST(SurfaceMapInAPackage, ThatIsNoneIsRefusedBeforeAnythingIsWritten) {
  const SurfaceMapPayload sound{Structure::LvBlood, {0.5F}, {1}, {3}, {{9}}};
  EXPECT_EQ(refusal([&] { (void)pack::pack_surface_map(sound, {0}); }), "");
  const auto refused = [&](auto&& change) {
    SurfaceMapPayload map = sound;
    change(map);
    return !refusal([&] { (void)pack::pack_surface_map(map, {0}); }).empty();
  };
  EXPECT_TRUE(refused([](auto& m) { m.long_axis[0] = 1.01F; }));
  EXPECT_TRUE(refused([](auto& m) { m.long_axis[0] = std::nanf(""); }));
  EXPECT_TRUE(refused([](auto& m) { m.angle_rad[0] = -0.1F; }));
  EXPECT_TRUE(refused([](auto& m) { m.segment[0] = 18; }));
  EXPECT_TRUE(refused([](auto& m) { m.segment[0] = 0; }));
  EXPECT_TRUE(refused([](auto& m) { m.thickness_mm[0][0] = 101; }));
  EXPECT_TRUE(refused([](auto& m) { m.thickness_mm.clear(); }));
  EXPECT_TRUE(refused([](auto& m) { m.angle_rad.push_back(0); }));
  EXPECT_NE(refusal([&] {
              (void)pack::pack_surface_map(sound, {0, 0});
            }).find("vertices"),
            std::string::npos);

  const test::TemporaryFolder folder;
  pack::PackageContent content = test::tiny_content();
  content.maps[0].segment.pop_back();
  EXPECT_NE(refusal([&] { pack::write_package(folder.path() / "a.beatlas", content); }), "");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(SurfaceMapInAPackage, IsMissedByNameWhereThereIsNone) {
  const test::TemporaryFolder folder;
  pack::PackageContent content = test::tiny_content();
  content.maps.clear();
  const atlas::Atlas opened = written(content, folder);
  EXPECT_NE(opened.surface(Structure::LvBlood), nullptr);
  EXPECT_EQ(opened.surface_map(Structure::LvBlood), nullptr);
  const std::string message = refusal([&] {
    (void)atlas::Atlas::open(folder.path() / "a.beatlas",
                             {.fields = {}, .surfaces = {}, .maps = {Structure::LvBlood}});
  });
  EXPECT_NE(message.find("holds no surface_map of lv_blood although its scene full would"),
            std::string::npos)
      << message;
}

}  // namespace
}  // namespace beatlas
