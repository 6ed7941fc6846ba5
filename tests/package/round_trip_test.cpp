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

bool same_lattice(const FieldPayload& a, const FieldPayload& b) {
  return a.structure == b.structure && a.origin_mm == b.origin_mm && a.voxel_mm == b.voxel_mm &&
         a.block_count == b.block_count && a.phases == b.phases && a.step_mm == b.step_mm &&
         a.inner_mm == b.inner_mm && a.outer_mm == b.outer_mm && a.blocks == b.blocks &&
         a.coefficients.size() == b.coefficients.size();
}

/// The clamped distance [mm] at a sample and phase, as payloads.h defines it.
double distance_mm(const FieldPayload& field, const Index3& sample, int phase) {
  double sum = 0;
  for (int n = 0; n < 81; ++n) {
    const Index3 to{n % 3 - 1, n / 3 % 3 - 1, n / 9 % 3 - 1};
    const int in_time = n / 27 - 1;
    double weight = in_time == 0 ? 4.0 / 6 : 1.0 / 6;
    std::size_t block = 0;
    Index3 local{};
    bool on_lattice = true;
    for (std::size_t axis = 3; axis-- > 0;) {
      weight *= to[axis] == 0 ? 4.0 / 6 : 1.0 / 6;
      const int at = sample[axis] + to[axis];
      on_lattice = on_lattice && at >= 0 && at < 8 * field.block_count[axis];
      block = block * std::size_t(field.block_count[axis]) + std::size_t(at / 8);
      local[axis] = at % 8;
    }
    double count = field.clamp_count(false);
    if (on_lattice) {
      const std::int32_t entry = field.blocks[block];
      if (entry == FieldPayload::kInside) count = field.clamp_count(true);
      const int wrapped = (phase + in_time + field.phases) % field.phases;
      if (entry >= 0) {
        count = field.coefficients[field.row_at(entry, local[1], local[2]) +
                                   std::size_t(8 * wrapped + local[0])];
      }
    }
    sum += weight * count;
  }
  return std::clamp(field.step_mm * sum, -field.inner_mm, field.outer_mm);
}

struct FieldError {
  double largest_mm = 0;
  double rms_mm = 0;
};

/// At every sample and phase of the lattice.
FieldError field_error(const FieldPayload& a, const FieldPayload& b) {
  FieldError out;
  double squares = 0;
  std::size_t count = 0;
  Index3 at{};
  for (at[2] = 0; at[2] < 8 * a.block_count[2]; ++at[2]) {
    for (at[1] = 0; at[1] < 8 * a.block_count[1]; ++at[1]) {
      for (at[0] = 0; at[0] < 8 * a.block_count[0]; ++at[0]) {
        for (int p = 0; p < a.phases; ++p) {
          const double given = distance_mm(a, at, p);
          const double error = std::abs(given - distance_mm(b, at, p));
          out.largest_mm = std::max(out.largest_mm, error);
          if (given <= -a.inner_mm || given >= a.outer_mm) continue;
          squares += error * error;
          ++count;
        }
      }
    }
  }
  out.rms_mm = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, count)));
  return out;
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

/// Along an axis.
double rms_error_mm(const SurfacePayload& a, const SurfacePayload& b) {
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t p = 0; p < a.positions.size(); ++p) {
    for (std::size_t v = 0; v < a.positions[p].size(); ++v) {
      squares += static_cast<double>((a.positions[p][v] - b.positions[p][v]).squaredNorm());
      count += 3;
    }
  }
  return std::sqrt(squares / static_cast<double>(count));
}

std::vector<Triangle> canonical(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles) {
    while (t[0] > t[1] || t[0] > t[2]) t = {t[1], t[2], t[0]};
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// With its vertices numbered as they are stored.
SurfacePayload renumbered(const SurfacePayload& surface, const std::vector<std::uint32_t>& given) {
  SurfacePayload out = surface;
  std::vector<std::uint32_t> stored(given.size());
  for (std::uint32_t v = 0; v < given.size(); ++v) stored[given[v]] = v;
  for (std::size_t p = 0; p < out.positions.size(); ++p) {
    for (std::size_t v = 0; v < given.size(); ++v) {
      out.positions[p][v] = surface.positions[p][given[v]];
    }
  }
  for (Triangle& triangle : out.triangles) {
    for (std::uint32_t& corner : triangle) corner = stored[corner];
  }
  return out;
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
  EXPECT_EQ(found["items"].size(), 11U);
  expected.erase("items");
  found.erase("items");
  EXPECT_EQ(expected, found);
  for (const FieldPayload& field : content.fields) {
    ASSERT_NE(opened.field(field.structure), nullptr);
    const FieldPayload& found_field = *opened.field(field.structure);
    EXPECT_TRUE(same_lattice(field, found_field));
    const FieldError error = field_error(field, found_field);
    EXPECT_LE(error.largest_mm,
              pack::kMostErrorSteps * pack::field_step_mm(field.structure, pack::EncodeOptions{}));
    EXPECT_GT(error.largest_mm, 0.001);  // it is quantised, so this can fail
  }
  for (const SurfacePayload& sample : content.surfaces) {
    const SurfacePayload surface = renumbered(sample, pack::pack_surface(sample).given);
    const auto decoded = opened.surface(surface.structure, surface.level);
    ASSERT_NE(decoded, nullptr);
    EXPECT_EQ(decoded->level, sample.level);
    // The stated bound of the format.
    EXPECT_LE(largest_error_mm(surface, *decoded), atlas::kMaxSurfaceErrorMm);
    EXPECT_GT(largest_error_mm(surface, *decoded), 0.001);  // it is quantised, so this can fail
    EXPECT_EQ(canonical(surface.triangles), canonical(decoded->triangles));
  }
  EXPECT_EQ(opened.field(Structure::RvBlood), nullptr);
  EXPECT_EQ(opened.surface(Structure::RvBlood), nullptr);
}

TEST(PackageRoundTrip, OfAFieldHoldsTheBoundOfItsStepAndCoarserStepsAreSmaller) {
  const FieldPayload field = test::beating_field(Structure::Heart, 15, 2, 5, 1.5);
  std::size_t finer = SIZE_MAX;
  for (double step_mm : {0.002, 0.01, 0.02, 0.1}) {
    const atlas::Bytes entry = pack::pack_field(field, step_mm);
    const FieldError error = field_error(field, atlas::decode_field(entry, Structure::Heart));
    EXPECT_LE(error.largest_mm, pack::kMostErrorSteps * step_mm);
    EXPECT_GT(error.largest_mm, 0.1 * step_mm);
    EXPECT_LE(error.rms_mm, step_mm / 3);
    EXPECT_LT(entry.size(), finer);
    finer = entry.size();
  }
  EXPECT_THROW((void)pack::pack_field(field, 0.0004), Error);
  EXPECT_THROW((void)pack::pack_field(field, 0.11), Error);
}

TEST(PackageRoundTrip, OfAFieldHoldsItsBoundForWildCoefficientsAndAnyNumberOfPhases) {
  for (int phases : {1, 2, 3, 4, 16}) {
    FieldPayload field = test::beating_field(Structure::Heart, 15, 2, phases, 3);
    field.inner_mm = 300;  // so that nothing is clamped
    field.outer_mm = 300;
    std::uint32_t state = 1;
    for (std::int16_t& c : field.coefficients) {
      state = state * 1664525U + 1013904223U;
      c = static_cast<std::int16_t>(state >> 16U);
    }
    field.coefficients[0] = -INT16_MAX;
    field.coefficients[1] = INT16_MAX;
    const FieldPayload stored =
        atlas::decode_field(pack::pack_field(field, 0.02), Structure::Heart);
    EXPECT_TRUE(same_lattice(field, stored));
    EXPECT_LE(field_error(field, stored).largest_mm, pack::kMostErrorSteps * 0.02) << phases;
  }
}

TEST(PackageRoundTrip, OfASurfaceHoldsItsBoundFarFromTheOriginAndWhenLarge) {
  for (double radius_mm : {0.02, 3.0, 400.0}) {
    const SurfacePayload sample =
        test::beating_surface(Structure::Heart, radius_mm, 0.2 * radius_mm, 5, 3);
    const auto packed = pack::pack_surface(sample);
    const SurfacePayload surface = renumbered(sample, packed.given);
    const auto decoded = atlas::decode_surface(packed.drc, packed.motion, Structure::Heart);
    EXPECT_LE(largest_error_mm(surface, decoded), atlas::kMaxSurfaceErrorMm) << radius_mm;
    EXPECT_EQ(canonical(surface.triangles), canonical(decoded.triangles));
  }
}

TEST(PackageRoundTrip, OfASurfaceHoldsTheBoundOfItsStepAndCoarserStepsAreSmaller) {
  const SurfacePayload sample = test::beating_surface(Structure::Heart, 60, 8, 5, 3);
  std::size_t finer = SIZE_MAX;
  for (double step_mm : {0.002, 0.01, 0.05, 0.5}) {
    const auto packed = pack::pack_surface(sample, step_mm);
    const SurfacePayload surface = renumbered(sample, packed.given);
    const auto decoded = atlas::decode_surface(packed.drc, packed.motion, Structure::Heart);
    EXPECT_LE(largest_error_mm(surface, decoded), step_mm);
    EXPECT_GT(largest_error_mm(surface, decoded), 0.4 * step_mm);
    EXPECT_LE(rms_error_mm(surface, decoded), 0.32 * step_mm);
    EXPECT_LT(packed.drc.size() + packed.motion.size(), finer) << step_mm;
    finer = packed.drc.size() + packed.motion.size();
  }
  EXPECT_THROW((void)pack::pack_surface(sample, 0.001), Error);
  EXPECT_EQ(pack::draco_bits(82, 0.01), 14);  // 8200 steps are between 2^13 and 2^14
  EXPECT_EQ(pack::draco_bits(82, 0.02), 13);
}

TEST(PackageRoundTrip, KeepsASurfaceOfOnePhaseAndOfTwoParts) {
  SurfacePayload sample = test::beating_surface(Structure::Heart, 20, 2, 1, 1);
  const SurfacePayload other = test::beating_surface(Structure::Heart, 5, 1, 1, 2);
  const auto offset = static_cast<std::uint32_t>(sample.positions[0].size());
  for (const auto& [a, b, c] : other.triangles) {
    sample.triangles.push_back({a + offset, b + offset, c + offset});
  }
  sample.positions[0].insert(sample.positions[0].end(), other.positions[0].begin(),
                             other.positions[0].end());
  const auto packed = pack::pack_surface(sample);
  const SurfacePayload surface = renumbered(sample, packed.given);
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
    const SurfacePayload sample = two_tetrahedra(shared);
    const auto packed = pack::pack_surface(sample);
    const SurfacePayload surface = renumbered(sample, packed.given);
    const auto decoded = atlas::decode_surface(packed.drc, packed.motion, Structure::Heart);
    EXPECT_LE(largest_error_mm(surface, decoded), atlas::kMaxSurfaceErrorMm) << shared;
    EXPECT_EQ(canonical(surface.triangles), canonical(decoded.triangles)) << shared;
  }
}

TEST(PackageRoundTrip, OfASurfaceHoldsItsBoundWhereFloatsAreCoarse) {
  SurfacePayload sample = test::beating_surface(Structure::Heart, 20, 3, 3, 2);
  for (auto& phase : sample.positions) {
    for (Vec3f& position : phase) position.x() += 50000;
  }
  const auto packed = pack::pack_surface(sample);
  const SurfacePayload surface = renumbered(sample, packed.given);
  const auto decoded = atlas::decode_surface(packed.drc, packed.motion, Structure::Heart);
  EXPECT_LE(largest_error_mm(surface, decoded), atlas::kMaxSurfaceErrorMm);
}

/// No two vertices are alike, so what comes back tells who is who.
TEST(PackageRoundTrip, GivesVerticesBackInTheOrderThatPackingTold) {
  for (const bool is_joined : {false, true}) {
    const SurfacePayload sample =
        is_joined ? two_tetrahedra(1) : test::beating_surface(Structure::Heart, 60, 8, 4, 5);
    const auto packed = pack::pack_surface(sample);
    const auto decoded = atlas::decode_surface(packed.drc, packed.motion, Structure::Heart);
    const std::size_t count = sample.positions[0].size();
    std::vector<bool> seen(count, false);
    ASSERT_EQ(packed.given.size(), count);
    for (std::size_t v = 0; v < count; ++v) {
      ASSERT_LT(packed.given[v], count);
      EXPECT_FALSE(seen[packed.given[v]]);
      seen[packed.given[v]] = true;
      std::size_t nearest = 0;
      for (std::size_t other = 0; other < count; ++other) {
        const auto far = [&](std::size_t to) {
          return (sample.positions[1][to] - decoded.positions[1][v]).squaredNorm();
        };
        if (far(other) < far(nearest)) nearest = other;
      }
      EXPECT_EQ(nearest, packed.given[v]) << v;
    }
  }
}

TEST(PackageRoundTrip, OfASurfaceThatJumpsHoldsItsBound) {
  SurfacePayload sample = test::beating_surface(Structure::Heart, 20, 3, 6, 3);
  std::uint32_t state = 1;
  for (auto& phase : sample.positions) {
    for (Vec3f& position : phase) {
      for (float& x : position) {
        state = state * 1664525U + 1013904223U;
        x += 1e-8F * static_cast<float>(state >> 8U);  // up to 0.17 mm
      }
    }
  }
  sample.positions[2][7].x() += 150;
  const auto packed = pack::pack_surface(sample);
  const auto decoded = atlas::decode_surface(packed.drc, packed.motion, Structure::Heart);
  EXPECT_LE(largest_error_mm(renumbered(sample, packed.given), decoded), atlas::kMaxSurfaceErrorMm);
}

TEST(PackageSize, OfASmoothBeatIsASmallShareOfItsRawBytes) {
  // Gates on bytes: a lost prediction step at least doubles these.
  const FieldPayload field = test::beating_field(Structure::Heart, 35, 5, 15, 1.5);
  EXPECT_LT(pack::pack_field(field, 0.02).size(), field.coefficients.size() * 2 / 4);
  const SurfacePayload surface = test::beating_surface(Structure::Heart, 35, 5, 15, 4);
  const auto packed = pack::pack_surface(surface);
  const std::size_t raw = surface.positions.size() * surface.positions[0].size() * 12;
  EXPECT_LT(packed.drc.size() + packed.motion.size(), raw / 12);
}

TEST(PackageWriter, GivesTheSameBytesForTheSameContentInAnyOrder) {
  const test::TemporaryFolder folder;
  pack::PackageContent content = test::tiny_content();
  pack::write_package(folder.path() / "a.beatlas", content);
  std::swap(content.fields[0], content.fields[1]);
  std::swap(content.surfaces[0], content.surfaces[2]);
  std::swap(content.maps[0], content.maps[1]);
  ::setenv("TZ", "Asia/Tokyo", 1);  // zip time stamps are local time
  ::tzset();
  pack::write_package(folder.path() / "b.beatlas", content);
  EXPECT_EQ(test::read_file(folder.path() / "a.beatlas"),
            test::read_file(folder.path() / "b.beatlas"));
}

TEST(PackageWriter, RefusesLevelsThatNoReaderWouldFind) {
  const test::TemporaryFolder folder;
  const auto refused = [&](const std::function<void(pack::PackageContent&)>& change) {
    pack::PackageContent content = test::tiny_content();
    change(content);
    return message_of([&] { pack::write_package(folder.path() / "a.beatlas", content); });
  };
  const auto is_level_1 = [](const auto& payload) { return payload.level == 1; };
  EXPECT_NE(refused([](auto& content) { content.manifest.surface_edges_mm = {2}; }).find("level 1"),
            std::string::npos);
  EXPECT_NE(refused([&](auto& content) {
              std::erase_if(content.surfaces, [&](const auto& each) { return !is_level_1(each); });
            }).find("no level 0"),
            std::string::npos);
  EXPECT_NE(refused([&](auto& content) {
              content.surfaces.push_back(content.surfaces.back());
            }).find("two payloads"),
            std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
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
  EXPECT_EQ(
      paths("palpation"),
      (Names{"atlas.json", "fields/heart.field.zst", "surfaces/lv_blood.drc",
             "surfaces/lv_blood.motion", "maps/lv_blood.map.zst", "surfaces/lv_blood.level1.drc",
             "surfaces/lv_blood.level1.motion", "maps/lv_blood.level1.map.zst"}));
  EXPECT_EQ(
      paths("anatomy"),
      (Names{"atlas.json", "surfaces/heart.drc", "surfaces/heart.motion", "surfaces/lv_blood.drc",
             "surfaces/lv_blood.motion", "maps/lv_blood.map.zst", "surfaces/lv_blood.level1.drc",
             "surfaces/lv_blood.level1.motion", "maps/lv_blood.level1.map.zst"}));
  EXPECT_EQ(paths("full").size(), 12U);
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
  EXPECT_EQ(open_as("anatomy", {{}, {}, true}),
            start + "holds no volume of heart; build it with --scene full");
  EXPECT_EQ(open_as("full", {{Structure::RvBlood}, {}}),
            start +
                "holds no field of rv_blood: its images gave no such structure, only heart, "
                "lv_blood");
}

// Atria are drawn and have no field in any scene: there is one to name no more than a way to it.
TEST(PackageReader, SaysOfWhatNoSceneHoldsWhatThereIsInItsPlace) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "heart.beatlas";
  pack::PackageContent content = test::tiny_content();
  content.manifest.structures.push_back(content.manifest.structures.back());
  content.manifest.structures.back().name = "la_blood";
  pack::write_package(file, content);
  EXPECT_EQ(message_of([&] {
              (void)atlas::Atlas::open(file, {{Structure::LaBlood}, {}});
            }),
            file.string() +
                ": holds no field of la_blood, which no scene has; its surface is in "
                "--scene anatomy or full");
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
  refuse([](auto& c) { c.volume->entry.pop_back(); });
  refuse([](auto& c) { c.volume = test::sample_content(3, 10, 1.5, 1).volume; });
  refuse([](auto& c) { c.fields.push_back(c.fields[0]); });
  refuse([](auto& c) { c.fields[0].coefficients.pop_back(); });
  refuse([](auto& c) { c.fields[0].blocks[0] = 7; });
  refuse([](auto& c) { c.fields[0].step_mm = 1e-4; });  // 6 mm are too many steps of it
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
