/// Packages that are cut, damaged or made to mislead: always Error{InvalidInput} or sound content.

#include <cstdlib>
#include <map>
#include <ostream>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/atlas.h"
#include "runtime/atlas/field_payload.h"
#include "runtime/atlas/surface_map_payload.h"
#include "runtime/atlas/surface_payload.h"
#include "runtime/atlas/volume_payload.h"
#include "runtime/atlas/zip_archive.h"
#include "runtime/atlas/zstd_frame.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/base/sha256.h"
#include "tests/package/hostile_package.h"

namespace beatlas {
namespace {

/// Offsets in an unpacked field.
struct FieldLayout {
  std::size_t first_leaf = 100;  ///< state of the first block that is a leaf
  std::size_t grades = 100;
  std::size_t lengths = 0;
};

FieldLayout layout_of(const Bytes& field) {
  std::array<std::uint32_t, 4> counts{};  // blocks along x y z, leaves
  std::memcpy(counts.data(), field.data() + 16, sizeof counts);
  FieldLayout out;
  out.grades += std::size_t{counts[0]} * counts[1] * counts[2];
  out.lengths = out.grades + counts[3];
  while (field.at(out.first_leaf) != std::byte{2}) ++out.first_leaf;
  return out;
}

void flip(Bytes& bytes, std::mt19937& random) {
  bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
}

/// How many packages each kind of damage is done to: as many as BEATLAS_DAMAGES says, as the
/// soak tests do, else a number that takes seconds.
int damages() {
  const char* told = std::getenv("BEATLAS_DAMAGES");
  return told == nullptr ? 2000 : std::stoi(told);
}

/// What became of packages that may be refused or sound: a test that damages nothing, or whose
/// damage always fails in the same place before it matters, shows in these.
struct Outcomes {
  int refused = 0;
  int sound = 0;
  int by_hash = 0;  ///< refused since a hash is wrong, whatever the content is

  void count(const std::string& message) {
    message.empty() ? ++sound : ++refused;
    by_hash += message.find("SHA-256") != std::string::npos ? 1 : 0;
  }
};

std::ostream& operator<<(std::ostream& out, const Outcomes& outcomes) {
  return out << outcomes.refused << " refused, " << outcomes.by_hash << " of them by their hash, "
             << outcomes.sound << " sound";
}

TEST_F(HostilePackage, IsReadWhenItIsSoundAndMadeByAnotherZipTool) {
  EXPECT_EQ(open(package_), "");
  EXPECT_EQ(open(test::raw_zip(entries_)), "");
  EXPECT_EQ(open(sealed(entries_)), "");
}

TEST_F(HostilePackage, IsRefusedWhereverItIsCut) {
  for (std::size_t size = 0; size < package_.size(); size += 64) {
    const auto end = package_.begin() + static_cast<std::ptrdiff_t>(size);
    EXPECT_NE(open(Bytes(package_.begin(), end)), "") << size;
  }
  EXPECT_NE(open(Bytes(package_.begin(), package_.end() - 1)), "");
}

TEST_F(HostilePackage, WithAFlippedByteIsRefusedUnlessTheByteMeansNothing) {
  std::mt19937 random(1);
  int refused = 0;
  for (int round = 0; round < damages(); ++round) {
    Bytes damaged = package_;
    flip(damaged, random);
    refused += open(damaged).empty() ? 0 : 1;
  }
  // Only time stamps, attributes and version fields of the zip may change unnoticed.
  EXPECT_GT(refused, 0.975 * damages());
}

TEST_F(HostilePackage, WithDamagedPayloadsAndRightHashesIsRefusedOrSound) {
  std::mt19937 random(2);
  std::map<std::string, Outcomes> of;
  for (int round = 0; round < damages(); ++round) {
    Entries entries = entries_;
    auto& [name, bytes] = entries[1 + random() % (entries.size() - 1)];
    for (std::uint32_t flips = 1 + random() % 4; flips > 0; --flips) flip(bytes, random);
    if (random() % 4 == 0) bytes.resize(random() % bytes.size());
    of[name].count(open(sealed(entries)));
  }
  ASSERT_EQ(of.size(), entries_.size() - 1) << "every payload was damaged";
  int sound = 0;
  for (const auto& [name, outcomes] : of) {
    EXPECT_EQ(outcomes.by_hash, 0) << name << ": the hashes were made right";
    EXPECT_GT(outcomes.refused, outcomes.sound) << name << ": " << outcomes;
    sound += outcomes.sound;
  }
  // A flipped bit of a coefficient or a point is another heart, and a sound one.
  EXPECT_GT(sound, 0.025 * damages());
}

TEST_F(HostilePackage, WithDamageBeneathTheCompressionIsRefusedOrSound) {
  std::mt19937 random(3);
  std::map<std::string, Outcomes> of;
  for (int round = 0; round < damages(); ++round) {
    Entries entries = entries_;
    constexpr std::array kPacked{"fields/heart.field.zst", "surfaces/heart.motion",
                                 "surfaces/lv_blood.level1.motion", "maps/lv_blood.map.zst",
                                 "volumes/heart.volume.zst"};
    const std::string name = kPacked[static_cast<std::size_t>(round) % kPacked.size()];
    Bytes& packed = entry(entries, name);
    const bool is_frame = name.ends_with(".zst");
    Bytes bytes = is_frame ? atlas::zstd_unpack(packed) : packed;
    // Most of the damage goes to the head, where the counts are.
    Bytes head(bytes.begin(), bytes.begin() + 100);
    flip(round % 16 < 12 ? head : bytes, random);
    if (round % 16 < 12) std::copy(head.begin(), head.end(), bytes.begin());
    packed = is_frame ? pack::zstd_pack(bytes) : bytes;
    of[name].count(open(sealed(entries)));
  }
  ASSERT_EQ(of.size(), 5U);
  for (const auto& [name, outcomes] : of) {
    EXPECT_EQ(outcomes.by_hash, 0) << name << ": the hashes were made right";
    EXPECT_GT(outcomes.refused, 0.025 * damages()) << name << ": " << outcomes;
    EXPECT_GT(outcomes.sound, 0.005 * damages()) << name << ": " << outcomes;
  }
}

TEST_F(HostilePackage, WithDamagedManifestTextIsRefusedOrSound) {
  std::mt19937 random(4);
  Outcomes outcomes;
  for (int round = 0; round < damages(); ++round) {
    Entries entries = entries_;
    flip(entries.front().second, random);
    outcomes.count(open(test::raw_zip(entries)));
  }
  // All but a letter of a free text or a digit of a figure counts.
  EXPECT_GT(outcomes.refused, 0.9 * damages()) << outcomes;
  EXPECT_LT(outcomes.by_hash, 0.1 * damages())
      << outcomes << ": the text is read before its hashes are";
  EXPECT_GT(outcomes.sound, 0) << outcomes;
}

TEST_F(HostilePackage, WithAnotherPayloadThanItsHashIsRefused) {
  Entries entries = entries_;
  entry(entries, "fields/heart.field.zst").back() ^= std::byte{1};
  EXPECT_NE(open(test::raw_zip(entries)).find("SHA-256"), std::string::npos);
}

TEST_F(HostilePackage, OfAFutureFormatIsRefusedByItsNumber) {
  const std::string message = open(with_manifest([](json& m) {
    m = {{"format", "beatlas"}, {"format_version", 8}, {"unheard", true}};
  }));
  EXPECT_NE(message.find("format version 8 is newer than version 7"), std::string::npos) << message;
}

TEST_F(HostilePackage, WithEntriesThatMisleadIsRefused) {
  const auto with_entry = [&](const std::string& name) {
    Entries entries = entries_;
    entries.emplace_back(name, Bytes(3));
    return open(test::raw_zip(entries));
  };
  for (const char* name : {"../evil", "/etc/passwd", "fields/../../evil", "a\\b", "C:evil", "extra",
                           "fields/", "evil\x1b[2J"}) {
    const std::string message = with_entry(name);
    EXPECT_NE(message, "") << name;
    EXPECT_EQ(message.find('\x1b'), std::string::npos);
  }
  EXPECT_NE(with_entry("atlas.json"), "");
  EXPECT_NE(with_entry("fields/heart.field.zst"), "");
  // A path that atlas.json itself gives must be the one that belongs to kind and structure.
  Entries entries = entries_;
  json manifest = manifest_of(entries);
  manifest["items"][0]["path"] = "../evil";
  entries[0].second = to_bytes(json_text(manifest));
  entries[1].first = "../evil";
  EXPECT_NE(open(test::raw_zip(entries)).find("/items/0/path"), std::string::npos);

  entries = entries_;
  std::swap(entries[0], entries[1]);
  EXPECT_NE(open(test::raw_zip(entries)).find("does not begin with atlas.json"), std::string::npos);
  entries = entries_;
  entries.pop_back();
  EXPECT_NE(open(test::raw_zip(entries)).find("lacks entry"), std::string::npos);
  entries = entries_;
  for (int i = 0; i < 2000; ++i) entries.emplace_back("extra" + std::to_string(i), Bytes());
  EXPECT_NE(open(test::raw_zip(entries)).find("more than 1024 entries"), std::string::npos);
}

TEST_F(HostilePackage, WithLyingSizesIsRefused) {
  const auto patched = [&](std::size_t at, std::uint32_t value) {
    Bytes zip = test::raw_zip(entries_);
    std::memcpy(zip.data() + at, &value, 4);
    return zip;
  };
  const Bytes zip = test::raw_zip(entries_);
  std::uint32_t directory = 0;
  std::memcpy(&directory, zip.data() + zip.size() - 6, 4);
  EXPECT_NE(open(patched(directory + 24, 0xFFFFFFF0U)), "");   // size of atlas.json
  EXPECT_NE(open(patched(directory + 20, 0xFFFFFFF0U)), "");   // stored size
  EXPECT_NE(open(patched(directory + 42, 0x7FFFFFFFU)), "");   // where it is
  EXPECT_NE(open(patched(zip.size() - 14, 0x00010001U)), "");  // one entry of eight
  EXPECT_NE(open(patched(zip.size() - 10, 0x7FFFFFFFU)), "");  // size of the directory
  EXPECT_NE(open(with_manifest([](json& m) { m["items"][0]["bytes"] = 1ULL << 60U; })), "");
}

/// A zip64 directory that claims 2^28 entries; a reader that believes it takes gigabytes.
TEST_F(HostilePackage, OfTheZip64KindIsRefusedBeforeItsCountIsBelieved) {
  Bytes zip = test::raw_zip(entries_);
  const Bytes end(zip.end() - 22, zip.end());
  zip.resize(zip.size() - 22);
  const std::uint64_t at = zip.size();
  const auto put = [&zip](std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i) zip.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFFU));
  };
  constexpr std::uint64_t kCount = std::uint64_t{1} << 28U;
  put(0x06064B50, 4);
  put(44, 8);
  put(45 | 45 << 16, 4);
  put(0, 8);
  put(kCount, 8);
  put(kCount, 8);
  put(46 * kCount, 8);
  put(0, 8);
  put(0x07064B50, 4);
  put(0, 4);
  put(at, 8);
  put(1, 4);
  zip.insert(zip.end(), end.begin(), end.end());
  for (std::size_t i = zip.size() - 14; i < zip.size() - 2; ++i) zip[i] = std::byte{0xFF};
  EXPECT_NE(open(zip).find("zip64"), std::string::npos);
}

TEST_F(HostilePackage, ThatUnpacksToFarMoreThanItsSizeIsRefused) {
  Entries entries = entries_;
  entry(entries, "fields/heart.field.zst") = pack::zstd_pack(Bytes(std::size_t{64} << 20U));
  EXPECT_NE(open(sealed(entries)).find("plausible"), std::string::npos);
}

/// Leaves without a term take two bytes a mode and nearly none of them once packed.
TEST_F(HostilePackage, WithAFieldOfFarMoreLeavesThanItsSizeHoldsIsRefused) {
  Entries entries = entries_;
  const std::string field = "fields/heart.field.zst";
  Bytes bytes = atlas::zstd_unpack(entry(entries, field));
  bytes.resize(100);
  const std::array<std::uint32_t, 5> counts{15, 16, 16, 16, 4096};  // phases, blocks, leaves
  std::memcpy(bytes.data() + 12, counts.data(), sizeof counts);
  std::memset(bytes.data() + 96, 0, 4);
  bytes.resize(100 + 4096, std::byte{2});
  bytes.resize(bytes.size() + std::size_t{4096} * (1 + 2 * 15 + 4), std::byte{0});
  entry(entries, field) = pack::zstd_pack(bytes);
  ASSERT_LT(entry(entries, field).size(), 1000U);
  EXPECT_NE(open(sealed(entries)).find("plausible"), std::string::npos);
}

TEST_F(HostilePackage, WithCountsThatContradictThePayloadIsRefused) {
  const auto patched = [&](const std::string& name, std::size_t at, std::uint64_t value,
                           std::size_t size) {
    Entries entries = entries_;
    const bool is_frame = name.ends_with(".zst");
    Bytes bytes = is_frame ? atlas::zstd_unpack(entry(entries, name)) : entry(entries, name);
    std::memcpy(bytes.data() + at, &value, size);
    entry(entries, name) = is_frame ? pack::zstd_pack(bytes) : bytes;
    return open(sealed(entries));
  };
  const std::string field = "fields/heart.field.zst";
  const std::string motion = "surfaces/heart.motion";
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::uint64_t nan_bits = 0;
  std::memcpy(&nan_bits, &nan, 8);
  for (std::uint64_t value : {std::uint64_t{0}, ~std::uint64_t{0}, std::uint64_t{1} << 31U}) {
    EXPECT_NE(patched(field, 12, value, 4), "");      // phases
    EXPECT_NE(patched(field, 16, value, 4), "");      // blocks along x
    EXPECT_NE(patched(field, 28, value, 4), "");      // leaves
    EXPECT_NE(patched(field, 96, value - 1, 4), "");  // terms apart
    EXPECT_NE(patched(motion, 12, value, 4), "");
    EXPECT_NE(patched(motion, 16, value, 4), "");
    EXPECT_NE(patched(motion, 20, value, 4), "");
    EXPECT_NE(patched(motion, 24, value - 1, 4), "");  // joined points
  }
  for (std::size_t at = 32; at < 96; at += 8) EXPECT_NE(patched(field, at, nan_bits, 8), "") << at;
  EXPECT_NE(patched(motion, 28, nan_bits, 8), "");
  EXPECT_NE(patched(motion, 8, 1, 4).find("version"), std::string::npos);
  EXPECT_NE(patched(motion, 36, 0, 2).find("scale"), std::string::npos);
  // Counts of the classes: one in another class, and more than there are.
  const std::size_t classes = 36 + 2 * 2 * 3;  // of 4 phases
  EXPECT_NE(patched(motion, classes, 1, 4), "");
  EXPECT_NE(patched(motion, classes, UINT32_MAX, 4), "");
  EXPECT_NE(patched(field, 0, 0, 1), "");
  EXPECT_NE(patched(field, 8, 1, 4).find("version"), std::string::npos);
  EXPECT_NE(patched(field, 100, 9, 1).find("block state"), std::string::npos);
  // One leaf more or less than the header says.
  const FieldLayout layout = layout_of(atlas::zstd_unpack(entry(entries_, field)));
  EXPECT_NE(patched(field, layout.first_leaf, 0, 1).find("leaves"), std::string::npos);
  EXPECT_NE(patched(field, layout.grades, 8, 1).find("grade"), std::string::npos);
  EXPECT_NE(patched(field, layout.lengths, 513, 2).find("terms"), std::string::npos);
  EXPECT_NE(patched(field, layout.lengths, 0, 2), "");  // terms that no mode has
  const std::string map = "maps/lv_blood.map.zst";
  std::uint32_t vertices = 0;
  std::memcpy(&vertices, atlas::zstd_unpack(entry(entries_, map)).data() + 12, sizeof vertices);
  for (std::uint64_t value : {std::uint64_t{0}, ~std::uint64_t{0}, std::uint64_t{1} << 31U}) {
    EXPECT_NE(patched(map, 12, value, 4), "");  // vertices
    EXPECT_NE(patched(map, 16, value, 4), "");  // phases
  }
  EXPECT_NE(patched(map, 20, nan_bits, 8).find("step"), std::string::npos);
  EXPECT_NE(patched(map, 8, 2, 4).find("version"), std::string::npos);
  EXPECT_NE(patched(map, 28, 18, 1).find("segment"), std::string::npos);
  EXPECT_NE(patched(map, 28, 0, 1).find("segment"), std::string::npos);
  EXPECT_NE(patched(map, 28 + 2 * vertices, 255, 1).find("long axis"), std::string::npos);
  EXPECT_NE(patched(map, 28 + 5 * vertices + 4 * vertices, 255, 1).find("thickness"),
            std::string::npos);
  const std::string volume = "volumes/heart.volume.zst";
  for (std::uint64_t value : {std::uint64_t{0}, ~std::uint64_t{0}, std::uint64_t{1} << 31U}) {
    EXPECT_NE(patched(volume, 12, value, 4), "");       // phases
    EXPECT_NE(patched(volume, 16, value, 4), "");       // size along x
    EXPECT_NE(patched(volume, 24, value, 4), "");       // along z
    EXPECT_NE(patched(volume, 156, value - 1, 4), "");  // terms apart
  }
  for (std::size_t at = 28; at < 156; at += 8) {
    EXPECT_NE(patched(volume, at, nan_bits, 8), "") << at;
  }
  EXPECT_NE(patched(volume, 0, 0, 1), "");
  EXPECT_NE(patched(volume, 8, 2, 4).find("version"), std::string::npos);
  EXPECT_NE(patched(volume, 160, 8, 1).find("grade"), std::string::npos);
}

/// Blocks without a term, as of the field above.
TEST_F(HostilePackage, WithAVolumeOfFarMoreSamplesThanItsSizeHoldsIsRefused) {
  Entries entries = entries_;
  const std::string volume = "volumes/heart.volume.zst";
  Bytes bytes = atlas::zstd_unpack(entry(entries, volume));
  bytes.resize(160);
  const std::array<std::uint32_t, 4> counts{15, 128, 128, 128};  // phases, size: 4096 blocks
  std::memcpy(bytes.data() + 12, counts.data(), sizeof counts);
  std::memset(bytes.data() + 156, 0, 4);
  bytes.resize(bytes.size() + std::size_t{4096} * (1 + 2 * 15 + 4), std::byte{0});
  entry(entries, volume) = pack::zstd_pack(bytes);
  EXPECT_NE(open(sealed(entries)).find("plausible"), std::string::npos);
}

/// Nearly nothing moves through very many phases: little is stored, much would be made of it.
TEST_F(HostilePackage, WithASurfaceOfFarMorePhasesThanItsSizeHoldsIsRefused) {
  Entries entries = entries_;
  Bytes& motion = entry(entries, "surfaces/heart.motion");
  const std::uint32_t many = 1024;
  const std::uint32_t vertices = std::uint32_t{1} << 20U;
  std::memcpy(motion.data() + 12, &vertices, 4);
  std::memcpy(motion.data() + 20, &many, 4);
  motion.resize(36);
  motion.resize(motion.size() + 4 * (many - 1) + 4 * 64, std::byte{1});
  EXPECT_NE(open(sealed(entries)).find("plausible"), std::string::npos);
}

TEST_F(HostilePackage, WithPayloadsOfOtherKindsInEachOthersPlaceIsRefused) {
  for (const char* one :
       {"fields/heart.field.zst", "surfaces/heart.motion", "maps/lv_blood.map.zst"}) {
    Entries entries = entries_;
    std::swap(entry(entries, one), entry(entries, "volumes/heart.volume.zst"));
    EXPECT_NE(open(sealed(entries)), "") << one;
  }
}

TEST_F(HostilePackage, WithADracoMeshOfManyClaimedTrianglesIsRefused) {
  Entries entries = entries_;
  Bytes& drc = entry(entries, "surfaces/heart.drc");
  // The second varint after the 11 bytes of header and traversal kind is the triangle count.
  std::size_t at = 11;
  while ((drc[at] & std::byte{0x80}) != std::byte{0}) ++at;
  ++at;
  std::size_t end = at;
  while ((drc[end] & std::byte{0x80}) != std::byte{0}) ++end;
  drc.erase(drc.begin() + static_cast<std::ptrdiff_t>(at),
            drc.begin() + static_cast<std::ptrdiff_t>(end) + 1);
  const Bytes many{std::byte{0xFF}, std::byte{0xFF}, std::byte{0xFF}, std::byte{0xFF},
                   std::byte{0x03}};
  drc.insert(drc.begin() + static_cast<std::ptrdiff_t>(at), many.begin(), many.end());
  EXPECT_NE(open(sealed(entries)).find("Draco"), std::string::npos);
}

TEST_F(HostilePackage, WithADeeplyNestedManifestIsRefused) {
  Entries entries = entries_;
  json manifest = manifest_of(entries);
  std::string text = json_text(manifest);
  const std::string deep = "{\"a\":" + std::string(1000000, '[') + std::string(1000000, ']') + "}";
  const std::string provenance = json_text(manifest["provenance"]);
  text.replace(text.find(provenance), provenance.size(), deep);
  entries.front().second = to_bytes(text);
  EXPECT_NE(open(test::raw_zip(entries)).find("nested"), std::string::npos);
}

TEST(PackageReader, RefusesWhatIsNoFile) {
  const test::TemporaryFolder folder;
  const auto refuse = [](const std::filesystem::path& file) {
    EXPECT_THROW((void)atlas::Atlas::open(file, {}), Error) << file;
  };
  refuse(folder.path());
  refuse(folder.path() / "missing.beatlas");
  refuse("/dev/zero");
  refuse("");
  test::write_file(folder.path() / "empty", {});
  refuse(folder.path() / "empty");
  test::write_file(folder.path() / "zip", test::raw_zip({}));
  refuse(folder.path() / "zip");
}

TEST(PackageReader, OfADracoEntryWithstandsManyDamagedOnes) {
  const auto surface = test::beating_surface(Structure::Heart, 10, 1, 2, 2);
  const pack::PackedSurface packed = pack::pack_surface(surface);
  std::mt19937 random(5);
  int sound = 0;
  for (int round = 0; round < 20000; ++round) {
    Bytes drc = packed.drc;
    for (std::uint32_t flips = 1 + random() % 3; flips > 0; --flips) flip(drc, random);
    if (random() % 8 == 0) drc.resize(random() % drc.size());
    try {
      atlas::check_surface(atlas::decode_surface(drc, packed.motion, Structure::Heart));
      ++sound;
    } catch (const Error& error) {
      ASSERT_EQ(error.code(), ErrorCode::InvalidInput);
    }
  }
  EXPECT_LT(sound, 20000);
}

}  // namespace
}  // namespace beatlas
