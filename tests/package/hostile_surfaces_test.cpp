/// Packages whose surfaces, levels of detail and maps do not belong together.

#include <gtest/gtest.h>

#include "pipeline/pack/payload_encoders.h"
#include "runtime/base/json_text.h"
#include "tests/package/hostile_package.h"

namespace beatlas {
namespace {

TEST_F(HostilePackage, WithAMapOfAnotherSurfaceIsRefused) {
  Entries entries = entries_;
  const atlas::SurfacePayload other = test::beating_surface(Structure::LvBlood, 6, 1, 4, 1);
  entry(entries, "maps/lv_blood.map.zst") =
      pack::pack_surface_map(test::beating_map(other), pack::pack_surface(other).given);
  EXPECT_NE(open(sealed(entries)).find("vertices"), std::string::npos);
}

TEST_F(HostilePackage, OfAFormatThatKnewNoMapsIsRefusedWithOne) {
  const std::string message = open(with_manifest([](json& m) {
    m["format_version"] = 3;
    m.erase("surface_edges_mm");
    for (json& item : m["items"]) item.erase("level");
  }));
  EXPECT_NE(message.find("/items/"), std::string::npos) << message;
}

TEST_F(HostilePackage, WhoseLevelsMisleadIsRefused) {
  const auto index_of = [&](const std::string& path) {
    const json items = manifest_of(entries_)["items"];
    for (std::size_t n = 0; n < items.size(); ++n) {
      if (items[n]["path"] == path) return n;
    }
    throw std::logic_error(path);
  };
  // A level that surface_edges_mm does not have, and one that is taken for another.
  EXPECT_NE(open(with_manifest([](json& m) { m["surface_edges_mm"] = {2}; })).find("/level"),
            std::string::npos);
  const std::size_t coarse = index_of("surfaces/lv_blood.level1.drc");
  EXPECT_NE(open(with_manifest([&](json& m) { m["items"][coarse].erase("level"); })).find("/path"),
            std::string::npos);
  // A surface without its motion; payloads of two levels exchanged.
  Entries entries = entries_;
  json manifest = manifest_of(entries);
  manifest["items"].erase(index_of("surfaces/lv_blood.level1.motion"));
  std::erase_if(entries,
                [](const auto& each) { return each.first == "surfaces/lv_blood.level1.motion"; });
  entries.front().second = to_bytes(json_text(manifest));
  EXPECT_NE(open(test::raw_zip(entries)).find("holds no motion of lv_blood"), std::string::npos);
  entries = entries_;
  std::swap(entry(entries, "surfaces/lv_blood.motion"),
            entry(entries, "surfaces/lv_blood.level1.motion"));
  EXPECT_NE(open(sealed(entries)), "");
  entries = entries_;
  std::swap(entry(entries, "maps/lv_blood.map.zst"),
            entry(entries, "maps/lv_blood.level1.map.zst"));
  EXPECT_NE(open(sealed(entries)).find("vertices"), std::string::npos);
}

}  // namespace
}  // namespace beatlas
