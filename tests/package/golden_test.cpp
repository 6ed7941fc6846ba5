#include <filesystem>

#include <gtest/gtest.h>

#include "runtime/atlas/atlas.h"
#include "runtime/atlas/info.h"
#include "runtime/atlas/surface_band.h"
#include "runtime/base/error.h"
#include "runtime/base/sha256.h"

namespace beatlas {
namespace {

std::string hash_of(const std::vector<std::int16_t>& values) {
  return sha256_hex(std::as_bytes(std::span(values)));
}

TEST(GoldenPackage, OfVersion3Loads) {
  const auto file = std::filesystem::path(BEATLAS_GOLDEN_FOLDER) / "v3.beatlas";
  ASSERT_LT(std::filesystem::file_size(file), 65536U);
  const atlas::Atlas bare = atlas::Atlas::open(file, {});
  const atlas::Atlas opened = atlas::Atlas::open(file, atlas::everything_in(bare.manifest()));
  const atlas::Manifest& manifest = opened.manifest();
  EXPECT_EQ(manifest.format_version, 3);
  EXPECT_EQ(manifest.scene, "full");
  EXPECT_EQ(manifest.phase_count(), 4);
  EXPECT_EQ(manifest.rr_interval_s, 0.9);
  EXPECT_EQ(manifest.end_systole, 2);
  EXPECT_EQ(manifest.items.size(), 7U);
  EXPECT_EQ(manifest.source_size, (Index3{64, 48, 12}));
  // Its balls shrink from radius r to 0.85 r.
  EXPECT_NEAR(atlas::ejection_fraction(manifest).value(), 1 - 0.85 * 0.85 * 0.85, 1e-12);

  const auto heart = opened.field(Structure::Heart);
  ASSERT_NE(heart, nullptr);
  EXPECT_EQ(heart->phases, 4);
  EXPECT_EQ(hash_of(heart->coefficients),
            "5a818dc51cefacc1ebceb51d04cc0f04868da5c7a958149d075a483361d70b2c");
  EXPECT_EQ(hash_of(opened.field(Structure::LvBlood)->coefficients),
            "07090773ecfae052dfacc9e25daceefad1739c4facc10b798d36075d5182b5f4");

  const auto surface = opened.surface(Structure::Heart);
  ASSERT_NE(surface, nullptr);
  EXPECT_EQ(surface->triangles.size(), 128U);
  ASSERT_EQ(surface->positions.size(), 4U);
  ASSERT_EQ(surface->positions[2].size(), 66U);
  // Recorded when the package was made; 5e-6 of 190 mm is a tenth of a count.
  EXPECT_TRUE(surface->positions[0][17].isApprox(Vec3f(123.91003F, 136.18828F, 91.90145F), 5e-6F))
      << surface->positions[0][17];
  EXPECT_TRUE(surface->positions[2][17].isApprox(Vec3f(124.61701F, 134.76628F, 92.61928F), 5e-6F))
      << surface->positions[2][17];
}

TEST(GoldenPackage, OfVersion3WithAVolumeLoads) {
  const auto file = std::filesystem::path(BEATLAS_GOLDEN_FOLDER) / "v3_volume.beatlas";
  ASSERT_LT(std::filesystem::file_size(file), 65536U);
  const atlas::Atlas bare = atlas::Atlas::open(file, {});
  EXPECT_EQ(bare.volume(), nullptr);
  const atlas::Needs needs = atlas::everything_in(bare.manifest());
  EXPECT_TRUE(needs.volume);
  EXPECT_TRUE(needs.surfaces.empty());
  const auto volume = atlas::Atlas::open(file, needs).volume();
  ASSERT_NE(volume, nullptr);
  EXPECT_EQ(volume->phases, 4);
  EXPECT_EQ(volume->size, (Index3{26, 26, 9}));
  EXPECT_EQ(volume->noise, 12);
  EXPECT_TRUE(volume->workspace_from_index.translation().isApprox(
      Vec3(128 - 12.5 * 1.25, 128 - 12.5 * 1.25, 96 - 4 * 4), 1e-12));
  EXPECT_EQ(hash_of(volume->counts),
            "8773ab56f3165dd5a894914510100ee7e6647bb714a0c8049bfd5307ed9cc06a");
}

TEST(GoldenPackage, OfVersion4LoadsWithItsMap) {
  const auto file = std::filesystem::path(BEATLAS_GOLDEN_FOLDER) / "v4.beatlas";
  ASSERT_LT(std::filesystem::file_size(file), 65536U);
  const atlas::Needs needs = atlas::everything_in(atlas::Atlas::open(file, {}).manifest());
  EXPECT_EQ(needs.maps, std::set{Structure::LvBlood});
  const atlas::Atlas opened = atlas::Atlas::open(file, needs);
  EXPECT_EQ(opened.manifest().format_version, 4);
  EXPECT_EQ(opened.manifest().items.size(), 8U);
  const auto map = opened.surface_map(Structure::LvBlood);
  ASSERT_NE(map, nullptr);
  ASSERT_EQ(map->segment.size(), 66U);
  ASSERT_EQ(map->thickness_mm.size(), 4U);
  // Recorded when the package was made.
  EXPECT_EQ(map->segment[17], 4);
  EXPECT_FLOAT_EQ(map->long_axis[17], 303.0F / 1024);
  EXPECT_FLOAT_EQ(map->angle_rad[17], 2.03712654F);
  EXPECT_FLOAT_EQ(map->thickness_mm[0][17], 9);
  EXPECT_FLOAT_EQ(map->thickness_mm[1][17], 10.8F);
  EXPECT_EQ(opened.surface(Structure::LvBlood)->positions[0].size(), 66U);
}

TEST(GoldenPackage, OfVersion5LoadsInBothLevels) {
  const auto file = std::filesystem::path(BEATLAS_GOLDEN_FOLDER) / "v5.beatlas";
  ASSERT_LT(std::filesystem::file_size(file), 65536U);
  const atlas::Needs needs = atlas::everything_in(atlas::Atlas::open(file, {}).manifest());
  EXPECT_EQ(needs.levels, (std::set{0, 1}));
  const atlas::Atlas opened = atlas::Atlas::open(file, needs);
  EXPECT_EQ(opened.manifest().format_version, 5);
  EXPECT_EQ(opened.manifest().surface_edges_mm, (std::vector<double>{2, 4}));
  EXPECT_EQ(opened.manifest().items.size(), 11U);
  const auto fine = opened.surface(Structure::LvBlood);
  const auto coarse = opened.surface(Structure::LvBlood, 1);
  ASSERT_NE(coarse, nullptr);
  EXPECT_EQ(fine->positions[0].size(), 66U);
  EXPECT_EQ(coarse->positions[0].size(), 18U);
  EXPECT_EQ(coarse->triangles.size(), 32U);
  EXPECT_EQ(opened.surface_map(Structure::LvBlood, 1)->segment.size(), 18U);
  EXPECT_EQ(opened.surface(Structure::Heart, 1), nullptr);
  // What is not asked for is not read.
  const atlas::Atlas alone =
      atlas::Atlas::open(file, {.fields = {}, .surfaces = {Structure::LvBlood}, .levels = {1}});
  EXPECT_EQ(alone.surface(Structure::LvBlood), nullptr);
  EXPECT_EQ(alone.surface(Structure::LvBlood, 1)->positions, coarse->positions);
}

TEST(GoldenPackage, OfVersion6LoadsWithTheMapOfTheRv) {
  const auto file = std::filesystem::path(BEATLAS_GOLDEN_FOLDER) / "v6.beatlas";
  ASSERT_LT(std::filesystem::file_size(file), 65536U);
  const atlas::Needs needs = atlas::everything_in(atlas::Atlas::open(file, {}).manifest());
  EXPECT_EQ(needs.maps, (std::set{Structure::LvBlood, Structure::RvBlood}));
  const atlas::Atlas opened = atlas::Atlas::open(file, needs);
  EXPECT_EQ(opened.manifest().format_version, 6);
  EXPECT_EQ(opened.manifest().items.size(), 14U);
  const auto map = opened.surface_map(Structure::RvBlood);
  ASSERT_NE(map, nullptr);
  EXPECT_EQ(map->segment, std::vector<std::uint8_t>(66, 0));
  // Recorded when the package was made.
  EXPECT_FLOAT_EQ(map->thickness_mm[0][17], 9);
  EXPECT_FLOAT_EQ(map->thickness_mm[1][17], 10.8F);
  EXPECT_EQ(opened.surface_map(Structure::RvBlood, 1), nullptr);
}

TEST(GoldenPackage, OfVersion7LoadsWithABand) {
  const auto file = std::filesystem::path(BEATLAS_GOLDEN_FOLDER) / "v7.beatlas";
  ASSERT_LT(std::filesystem::file_size(file), 65536U);
  const atlas::Atlas opened =
      atlas::Atlas::open(file, {.fields = {}, .surfaces = {Structure::RvBlood}});
  const atlas::Manifest& manifest = opened.manifest();
  EXPECT_EQ(manifest.format_version, 7);
  EXPECT_FALSE(atlas::band_query(manifest, Structure::LvBlood).has_value());
  const auto band = atlas::band_query(manifest, Structure::RvBlood);
  ASSERT_TRUE(band.has_value());
  // In the middle of a slice, across it and along it.
  const Affine workspace_from_index = manifest.workspace_from_lps * manifest.source_lps_from_index;
  const Vec3 place = workspace_from_index * Vec3(1, 1, 1);
  const Vec3 across = workspace_from_index.linear().col(0).normalized();
  const Vec3 along = workspace_from_index.linear().inverse().row(2).normalized();
  EXPECT_NEAR(band->half_width_mm(place, across, 0), 1.5, 1e-6);
  EXPECT_NEAR(band->half_width_mm(place, along, 0.6), 4, 1e-6);
}

TEST(GoldenPackage, OfOlderVersionsIsRefusedByItsNumber) {
  for (const std::string number : {"1", "2"}) {
    const auto file = std::filesystem::path(BEATLAS_GOLDEN_FOLDER) / ("v" + number + ".beatlas");
    try {
      (void)atlas::Atlas::open(file, {});
      FAIL() << "accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      EXPECT_NE(
          std::string(error.what()).find("format version " + number + " is older than version 3"),
          std::string::npos)
          << error.what();
    }
  }
}

}  // namespace
}  // namespace beatlas
