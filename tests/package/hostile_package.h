#pragma once
/// A package that tests damage: opened, it must give Error{InvalidInput} or sound content.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/atlas/atlas.h"
#include "runtime/atlas/field_payload.h"
#include "runtime/atlas/surface_map_payload.h"
#include "runtime/atlas/surface_payload.h"
#include "runtime/atlas/volume_payload.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/base/sha256.h"
#include "tests/package/sample_package.h"

namespace beatlas {

using atlas::Bytes;
using Entries = std::vector<std::pair<std::string, Bytes>>;
using nlohmann::json;

inline const atlas::Needs kBoth{{Structure::Heart, Structure::LvBlood},
                                {Structure::Heart, Structure::LvBlood},
                                true,
                                {Structure::LvBlood},
                                {0, 1}};

inline Bytes to_bytes(const std::string& text) {
  Bytes bytes;
  for (char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

inline json manifest_of(const Entries& entries) {
  const Bytes& bytes = entries.front().second;
  return parse_json(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

class HostilePackage : public ::testing::Test {
 protected:
  HostilePackage() {
    pack::write_package(file_, test::tiny_content());
    package_ = test::read_file(file_);
    entries_ = test::raw_unzip(package_);
  }

  /// Empty if it opened; the message of an Error{InvalidInput}; anything else fails the test.
  std::string open(const Bytes& package) {
    test::write_file(file_, package);
    try {
      const atlas::Atlas opened = atlas::Atlas::open(file_, kBoth);
      for (Structure structure : {Structure::Heart, Structure::LvBlood}) {
        atlas::check_field(*opened.field(structure));
        atlas::check_surface(*opened.surface(structure));
        if (const auto coarse = opened.surface(structure, 1)) atlas::check_surface(*coarse);
      }
      atlas::check_surface_map(*opened.surface_map(Structure::LvBlood));
      if (const auto coarse = opened.surface_map(Structure::LvBlood, 1)) {
        atlas::check_surface_map(*coarse);
      }
      atlas::check_volume(*opened.volume());
      return {};
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput) << error.what();
      EXPECT_EQ(std::string(error.what()).find(file_.string()), 0U) << error.what();
      return error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << "another exception: " << error.what();
      return error.what();
    }
  }

  /// With sizes and hashes of atlas.json made right again.
  static Bytes sealed(Entries entries) {
    json manifest = manifest_of(entries);
    for (json& item : manifest["items"]) {
      for (const auto& [name, bytes] : entries) {
        if (name != item["path"]) continue;
        item["bytes"] = bytes.size();
        item["sha256"] = sha256_hex(bytes);
      }
    }
    entries.front().second = to_bytes(json_text(manifest));
    return test::raw_zip(entries);
  }

  Bytes with_manifest(const std::function<void(json&)>& change) {
    Entries entries = entries_;
    json manifest = manifest_of(entries);
    change(manifest);
    entries.front().second = to_bytes(json_text(manifest));
    return test::raw_zip(entries);
  }

  Bytes& entry(Entries& entries, const std::string& name) {
    for (auto& [path, bytes] : entries) {
      if (path == name) return bytes;
    }
    throw std::logic_error(name);
  }

  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "a.beatlas";
  Bytes package_;
  Entries entries_;
};

}  // namespace beatlas
