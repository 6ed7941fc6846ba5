#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/atlas.h"
#include "runtime/atlas/field_payload.h"
#include "runtime/atlas/scene.h"
#include "runtime/atlas/surface_payload.h"
#include "runtime/atlas/zstd_frame.h"
#include "runtime/base/error.h"
#include "tests/package/sample_package.h"

namespace beatlas {
namespace {

using atlas::FieldPayload;
using atlas::SurfacePayload;
using Triangle = std::array<std::uint32_t, 3>;

bool same_field(const FieldPayload& a, const FieldPayload& b) {
  return a.structure == b.structure && a.origin_mm == b.origin_mm && a.voxel_mm == b.voxel_mm &&
         a.block_count == b.block_count && a.phases == b.phases && a.step_mm == b.step_mm &&
         a.inner_mm == b.inner_mm && a.outer_mm == b.outer_mm && a.blocks == b.blocks &&
         a.coefficients == b.coefficients &&
         std::equal(a.leaves.begin(), a.leaves.end(), b.leaves.begin(), b.leaves.end(),
                    [](const FieldPayload::Leaf& x, const FieldPayload::Leaf& y) {
                      return x.active == y.active && x.inside == y.inside &&
                             x.first_active == y.first_active;
                    });
}

double largest_error_mm(const SurfacePayload& a, const SurfacePayload& b) {
  double largest = a.positions.size() == b.positions.size() ? 0 : INFINITY;
  for (std::size_t p = 0; p < a.positions.size() && std::isfinite(largest); ++p) {
    if (a.positions[p].size() != b.positions[p].size()) return INFINITY;
    for (std::size_t v = 0; v < a.positions[p].size(); ++v) {
      const Vec3 difference = a.positions[p][v].cast<double>() - b.positions[p][v].cast<double>();
      largest = std::max(largest, difference.norm());
    }
  }
  return largest;
}

std::vector<Triangle> canonical(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles) {
    while (t[0] > t[1] || t[0] > t[2]) t = {t[1], t[2], t[0]};
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

std::string message_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}

TEST(PackageRoundTrip, GivesBackManifestFieldsAndSurfaces) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "a.beatlas";
  const pack::PackageContent content = test::sample_content(7, 22, 1.5, 3);
  pack::write_package(file, content);
  const atlas::Atlas bare = atlas::Atlas::open(file, {});
  EXPECT_EQ(bare.field(Structure::Heart), nullptr);
  const atlas::Atlas opened = atlas::Atlas::open(file, atlas::everything_in(bare.manifest()));

  nlohmann::json expected = atlas::manifest_to_json(content.manifest);
  nlohmann::json found = atlas::manifest_to_json(opened.manifest());
  EXPECT_EQ(found["items"].size(), 6U);
  expected.erase("items");
  found.erase("items");
  EXPECT_EQ(expected, found);
  for (const FieldPayload& field : content.fields) {
    ASSERT_NE(opened.field(field.structure), nullptr);
    EXPECT_TRUE(same_field(field, *opened.field(field.structure)));
  }
  for (const SurfacePayload& surface : content.surfaces) {
    const auto decoded = opened.surface(surface.structure);
    ASSERT_NE(decoded, nullptr);
    // The stated bound of the format; rounding to 0.01 mm along three axes gives 0.0087 mm.
    EXPECT_LE(largest_error_mm(surface, *decoded), atlas::kMaxSurfaceErrorMm);
    EXPECT_GT(largest_error_mm(surface, *decoded), 0.001);  // it is quantised, so this can fail
    EXPECT_EQ(canonical(surface.triangles), canonical(decoded->triangles));
  }
  EXPECT_EQ(opened.field(Structure::RvBlood), nullptr);
  EXPECT_EQ(opened.surface(Structure::RvBlood), nullptr);
}

TEST(PackageRoundTrip, OfAFieldIsExactForWildCoefficients) {
  FieldPayload field = test::beating_field(Structure::Heart, 15, 2, 3, 2);
  std::uint32_t state = 1;
  for (std::int16_t& c : field.coefficients) {
    state = state * 1664525U + 1013904223U;
    c = static_cast<std::int16_t>(state >> 16U);
  }
  field.coefficients[0] = INT16_MIN;
  field.coefficients[1] = INT16_MAX;
  EXPECT_TRUE(same_field(field, atlas::decode_field(pack::pack_field(field), Structure::Heart)));
}

TEST(PackageRoundTrip, OfASurfaceHoldsItsBoundFarFromTheOriginAndWhenLarge) {
  for (double radius_mm : {0.02, 3.0, 400.0}) {
    const SurfacePayload surface =
        test::beating_surface(Structure::Heart, radius_mm, 0.2 * radius_mm, 5, 3);
    const auto packed = pack::pack_surface(surface);
    const auto decoded = atlas::decode_surface(packed.drc, packed.motion, Structure::Heart);
    EXPECT_LE(largest_error_mm(surface, decoded), atlas::kMaxSurfaceErrorMm) << radius_mm;
    EXPECT_EQ(canonical(surface.triangles), canonical(decoded.triangles));
  }
}

TEST(PackageRoundTrip, OfASurfaceHoldsTheBoundOfItsStepAndCoarserStepsAreSmaller) {
  const SurfacePayload surface = test::beating_surface(Structure::Heart, 60, 8, 5, 3);
  std::size_t finer = SIZE_MAX;
  for (double step_mm : {0.002, 0.01, 0.05, 0.5}) {
    const auto packed = pack::pack_surface(surface, step_mm);
    const auto decoded = atlas::decode_surface(packed.drc, packed.motion, Structure::Heart);
    EXPECT_LE(largest_error_mm(surface, decoded), step_mm);
    EXPECT_GT(largest_error_mm(surface, decoded), 0.4 * step_mm);  // half a step on some axis
    EXPECT_LT(packed.drc.size() + packed.motion.size(), finer) << step_mm;
    finer = packed.drc.size() + packed.motion.size();
  }
  EXPECT_THROW((void)pack::pack_surface(surface, 0.001), Error);
  EXPECT_EQ(pack::draco_bits(82, 0.01), 14);  // 8200 steps are between 2^13 and 2^14
  EXPECT_EQ(pack::draco_bits(82, 0.02), 13);
}

TEST(PackageRoundTrip, KeepsASurfaceOfOnePhaseAndOfTwoParts) {
  SurfacePayload surface = test::beating_surface(Structure::Heart, 20, 2, 1, 1);
  const SurfacePayload other = test::beating_surface(Structure::Heart, 5, 1, 1, 2);
  const auto offset = static_cast<std::uint32_t>(surface.positions[0].size());
  for (const auto& [a, b, c] : other.triangles) {
    surface.triangles.push_back({a + offset, b + offset, c + offset});
  }
  surface.positions[0].insert(surface.positions[0].end(), other.positions[0].begin(),
                              other.positions[0].end());
  const auto packed = pack::pack_surface(surface);
  const auto decoded = atlas::decode_surface(packed.drc, packed.motion, Structure::Heart);
  EXPECT_LE(largest_error_mm(surface, decoded), atlas::kMaxSurfaceErrorMm);
  EXPECT_EQ(canonical(surface.triangles), canonical(decoded.triangles));
}

/// Tetrahedra that share `shared` vertices; {0, 1, 2} with other apexes.
SurfacePayload two_tetrahedra(int shared) {
  SurfacePayload surface;
  surface.positions.assign(2, {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {0, 0, 9}});
  const std::vector<Triangle> one{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  surface.triangles = one;
  for (const Triangle& t : one) {
    Triangle other = t;
    for (std::uint32_t& v : other) {
      if (static_cast<int>(v) >= shared) v += static_cast<std::uint32_t>(4 - shared);
    }
    surface.triangles.push_back(other);
  }
  for (auto& phase : surface.positions) {
    for (int v = shared; v < 4; ++v) phase.push_back(Vec3f(-1.5F, -2, -3 - 2 * float(v)));
  }
  for (Vec3f& position : surface.positions[1]) position *= 1.2F;
  return surface;
}

TEST(PackageRoundTrip, KeepsASurfaceThatTouchesItselfAtAVertexOrAnEdge) {
  for (int shared : {1, 2}) {
    const SurfacePayload surface = two_tetrahedra(shared);
    const auto packed = pack::pack_surface(surface);
    const auto decoded = atlas::decode_surface(packed.drc, packed.motion, Structure::Heart);
    EXPECT_LE(largest_error_mm(surface, decoded), atlas::kMaxSurfaceErrorMm) << shared;
    EXPECT_EQ(canonical(surface.triangles), canonical(decoded.triangles)) << shared;
  }
}

TEST(PackageRoundTrip, OfASurfaceHoldsItsBoundWhereFloatsAreCoarse) {
  SurfacePayload surface = test::beating_surface(Structure::Heart, 20, 3, 3, 2);
  for (auto& phase : surface.positions) {
    for (Vec3f& position : phase) position.x() += 50000;
  }
  const auto packed = pack::pack_surface(surface);
  const auto decoded = atlas::decode_surface(packed.drc, packed.motion, Structure::Heart);
  EXPECT_LE(largest_error_mm(surface, decoded), atlas::kMaxSurfaceErrorMm);
}

TEST(PackageSize, OfASmoothBeatIsAQuarterOfItsRawBytesOrLess) {
  // Gates on bytes: a lost prediction step at least doubles these.
  const FieldPayload field = test::beating_field(Structure::Heart, 35, 5, 15, 1.5);
  EXPECT_LT(pack::pack_field(field).size(), field.coefficients.size() * 2 / 4);
  const SurfacePayload surface = test::beating_surface(Structure::Heart, 35, 5, 15, 4);
  const auto packed = pack::pack_surface(surface);
  const std::size_t raw = surface.positions.size() * surface.positions[0].size() * 12;
  EXPECT_LT(packed.drc.size() + packed.motion.size(), raw / 4);
}

TEST(PackageWriter, GivesTheSameBytesForTheSameContentInAnyOrder) {
  const test::TemporaryFolder folder;
  pack::PackageContent content = test::tiny_content();
  pack::write_package(folder.path() / "a.beatlas", content);
  std::swap(content.fields[0], content.fields[1]);
  std::swap(content.surfaces[0], content.surfaces[1]);
  ::setenv("TZ", "Asia/Tokyo", 1);  // zip time stamps are local time
  ::tzset();
  pack::write_package(folder.path() / "b.beatlas", content);
  EXPECT_EQ(test::read_file(folder.path() / "a.beatlas"),
            test::read_file(folder.path() / "b.beatlas"));
}

TEST(PackageWriter, PutsIntoAPackageWhatItsSceneHolds) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "a.beatlas";
  const auto paths = [&](const std::string& scene) {
    pack::PackageContent content = test::tiny_content();
    content.manifest.scene = scene;
    pack::write_package(file, content);
    std::vector<std::string> names;
    for (const auto& [name, bytes] : test::raw_unzip(test::read_file(file))) names.push_back(name);
    return names;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(paths("palpation"), (Names{"atlas.json", "fields/heart.field.zst"}));
  EXPECT_EQ(paths("anatomy"),
            (Names{"atlas.json", "surfaces/heart.drc", "surfaces/heart.motion.zst",
                   "surfaces/lv_blood.drc", "surfaces/lv_blood.motion.zst"}));
  EXPECT_EQ(paths("full").size(), 7U);
  EXPECT_EQ(atlas::Atlas::open(file, {}).manifest().structures.size(), 2U);
}

TEST(PackageReader, NamesTheSceneThatWouldHoldAMissingPayload) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "heart.beatlas";
  const auto open_as = [&](const std::string& scene, const atlas::Needs& needs) {
    pack::PackageContent content = test::tiny_content();
    content.manifest.scene = scene;
    pack::write_package(file, content);
    return message_of([&] { (void)atlas::Atlas::open(file, needs); });
  };
  const std::string start = file.string() + ": ";
  EXPECT_EQ(open_as("palpation", {{Structure::LvBlood}, {}}),
            start + "holds no field of lv_blood; build it with --scene full");
  EXPECT_EQ(open_as("anatomy", {{Structure::Heart}, {}}),
            start + "holds no field of heart; build it with --scene palpation or full");
  EXPECT_EQ(open_as("palpation", {{}, {Structure::Heart}}),
            start + "holds no surface of heart; build it with --scene anatomy or full");
  EXPECT_EQ(open_as("full", {{Structure::RvBlood}, {}}),
            start +
                "holds no field of rv_blood: its images gave no such structure, only heart, "
                "lv_blood");
}

TEST(PackageWriter, RefusesContentThatTheReaderWouldRefuse) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "a.beatlas";
  const auto refuse = [&](auto&& change) {
    pack::PackageContent content = test::tiny_content();
    change(content);
    (void)message_of([&] { pack::write_package(file, content); });
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  };
  refuse([](auto& c) { c.manifest.rr_interval_s = std::nan(""); });
  refuse([](auto& c) { c.manifest.scene = "everything"; });
  refuse([](auto& c) { c.manifest.structures[1].volume_ml.pop_back(); });
  refuse([](auto& c) { c.manifest.structures.pop_back(); });
  refuse([](auto& c) { c.manifest.workspace_from_lps.linear() *= 1.1; });
  refuse([](auto& c) { c.fields.push_back(c.fields[0]); });
  refuse([](auto& c) { c.fields[0].coefficients.pop_back(); });
  refuse([](auto& c) { c.fields[0].blocks[0] = 7; });
  refuse([](auto& c) { c.fields[0].leaves[0].first_active = 1; });
  refuse([](auto& c) { c.fields[0].voxel_mm = std::nan(""); });
  refuse([](auto& c) { c.fields[0] = test::beating_field(Structure::Heart, 9, 1, 3, 1.5); });
  refuse([](auto& c) { c.surfaces[0].positions[2][5].x() = NAN; });
  refuse([](auto& c) { c.surfaces[0].positions[2][5].x() += 400; });
  refuse([](auto& c) { c.surfaces[0].positions[2].pop_back(); });
  refuse([](auto& c) { c.surfaces[0].triangles[3][1] = 1000000; });
  refuse([](auto& c) { c.surfaces[0].triangles[3][1] = c.surfaces[0].triangles[3][0]; });
  refuse([](auto& c) {
    for (auto& phase : c.surfaces[0].positions) phase.push_back(Vec3f::Zero());
  });
}

}  // namespace
}  // namespace beatlas
