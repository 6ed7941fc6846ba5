#include "runtime/atlas/field_payload.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <system_error>
#include <thread>

#include "runtime/atlas/manifest.h"
#include "runtime/atlas/zstd_frame.h"

namespace beatlas::atlas {
namespace {

constexpr int kMaxBlocksAlongAxis = 4096;
constexpr double kMaxClampSteps = 32765;  // FieldPayload::clamp_count must fit
constexpr const char* kRebuild = "; build the package again";

enum BlockState : std::uint8_t { kStateOutside = 0, kStateInside = 1, kStateLeaf = 2 };

void require(bool ok, const std::string& what) {
  if (!ok) throw_invalid("field " + what + kRebuild);
}

bool within(double value, double low, double high) { return value >= low && value <= high; }

void check_header(const FieldPayload& field) {
  for (int axis = 0; axis < 3; ++axis) {
    require(within(field.origin_mm[axis], -1e5, 1e5), "has no finite origin");
    const int count = field.block_count[static_cast<std::size_t>(axis)];
    require(count >= 1 && count <= kMaxBlocksAlongAxis, "has a block count out of range");
  }
  require(within(field.voxel_mm, 0.01, 100), "has a voxel size out of range");
  require(within(field.step_mm, 1e-6, 10), "has a step out of range");
  require(field.inner_mm > 0 && field.inner_mm <= 1000, "has an inner clamp out of range");
  require(field.outer_mm > 0 && field.outer_mm <= 1000, "has an outer clamp out of range");
  require(std::max(field.inner_mm, field.outer_mm) / field.step_mm <= kMaxClampSteps,
          "has a step too small for its clamps");
  require(field.phases >= 1 && field.phases <= kMaxPhases, "has a phase count out of range");
}

std::uint64_t block_total(const FieldPayload& field) {
  std::uint64_t total = 1;
  for (int count : field.block_count) total *= static_cast<std::uint64_t>(count);
  return total;
}

/// What the header says beside the payload's own members.
struct Stored {
  std::size_t leaves = 0;
  double quantum_mm = 0;
  std::size_t apart = 0;
};

std::int32_t unzigzag(std::uint32_t code) {
  return static_cast<std::int32_t>(code >> 1U) ^ -static_cast<std::int32_t>(code & 1U);
}

/// The terms written apart of some leaves. Beyond its end it gives 0, and says so.
class ApartReader {
 public:
  explicit ApartReader(ByteView bytes) : bytes_(bytes) {}
  [[nodiscard]] std::uint32_t next() noexcept {
    std::uint32_t code = 0;
    if (at_ + sizeof(code) <= bytes_.size()) std::memcpy(&code, bytes_.data() + at_, sizeof(code));
    at_ += sizeof(code);
    return code;
  }
  [[nodiscard]] bool is_at_end() const noexcept { return at_ == bytes_.size(); }

 private:
  ByteView bytes_;
  std::size_t at_ = 0;
};

constexpr float kApart = 1e30F;  // larger than any count that stands in its band

/// The counts that a byte stands for.
using Pair = std::array<float, 2>;
std::array<Pair, 256> byte_counts(bool paired) {
  std::array<Pair, 256> out{};
  for (std::uint32_t byte = 0; byte < out.size(); ++byte) {
    const auto count = [](std::uint32_t code, std::uint32_t apart) {
      return code == apart ? kApart : static_cast<float>(unzigzag(code));
    };
    if (paired) {
      out[byte] = {count(byte >> 4U, kApartHalf), count(byte & 0xFU, kApartHalf)};
    } else {
      out[byte] = {count(byte, kApartByte), 0};
    }
  }
  return out;
}

/// Reads the terms of one band, front to back.
class BandReader {
 public:
  BandReader() = default;
  BandReader(ByteView bytes, std::size_t band) : at_(bytes.data()), band_(band) {}

  /// Puts those of a mode of `length` terms to their places in `to`.
  /// @pre the band's bytes are those of all lengths
  void read(std::size_t length, const std::array<std::uint16_t, LeafTransform::kSamples>& order,
            ApartReader& apart, float* to) noexcept {
    static const std::array<Pair, 256> kBytes = byte_counts(false);
    static const std::array<Pair, 256> kHalves = byte_counts(true);
    const auto counted = [&apart](float count) {
      return count == kApart ? static_cast<float>(unzigzag(apart.next())) : count;
    };
    const std::size_t end = std::min(length, kBandEnds[band_ + 1]);
    std::size_t rank = kBandEnds[band_];
    if (band_ < kFirstPairedBand) {
      for (; rank < end; ++rank) {
        to[order[rank]] = counted(kBytes[std::to_integer<std::size_t>(*at_++)][0]);
      }
      return;
    }
    for (; rank + 1 < end; rank += 2) {
      const Pair& both = kHalves[std::to_integer<std::size_t>(*at_++)];
      to[order[rank]] = counted(both[0]);
      to[order[rank + 1]] = counted(both[1]);
    }
    if (rank < end) to[order[rank]] = counted(kHalves[std::to_integer<std::size_t>(*at_++)][0]);
  }

 private:
  const std::byte* at_ = nullptr;
  std::size_t band_ = 0;
};

/// Leaves that one thread decodes.
struct Share {
  std::size_t first = 0;
  std::size_t end = 0;
  std::array<std::size_t, kBands> band_at{};  ///< where their bytes begin in each band
  std::size_t apart_at = 0;                   ///< in terms
  bool sound = true;
};

class CoefficientDecoder {
 public:
  CoefficientDecoder(ByteReader& reader, FieldPayload& field, const Stored& stored)
      : field_(field),
        quantum_(stored.quantum_mm / field.step_mm),
        phases_(static_cast<std::size_t>(field.phases)),
        grades_(reader.take(stored.leaves)),
        lengths_(stored.leaves * phases_),
        apart_counts_(stored.leaves),
        transform_(field.phases) {
    for (const std::byte grade : grades_) {
      require(std::to_integer<int>(grade) <= kMaxGrade, "has a leaf of an unknown grade");
    }
    reader.get_many(lengths_.data(), lengths_.size());
    for (const std::uint16_t length : lengths_) {
      require(length <= LeafTransform::kSamples, "has a mode of too many terms");
    }
    reader.get_many(apart_counts_.data(), apart_counts_.size());
    const Share all = share_of(stored.leaves);
    for (std::size_t b = 0; b < kBands; ++b) bands_[b] = reader.take(all.band_at[b]);
    require(
        all.apart_at == stored.apart && reader.remaining() == sizeof(std::uint32_t) * stored.apart,
        "has counts that its size contradicts");
    apart_ = reader.take(reader.remaining());
  }

  void decode() {
    field_.coefficients.resize(grades_.size() * leaf_size());
    const std::size_t count =
        std::clamp<std::size_t>(grades_.size() / kLeavesAThread, 1,
                                std::clamp(std::thread::hardware_concurrency(), 1U, kMostThreads));
    std::vector<Share> shares;
    for (std::size_t n = 0; n < count; ++n) {
      shares.push_back(share_of(n * grades_.size() / count));
      shares.back().end = (n + 1) * grades_.size() / count;
    }
    std::vector<LeafTransform::Inverse> inverses(count, LeafTransform::Inverse(transform_));
    std::vector<std::thread> threads;
    threads.reserve(count);
    std::size_t begun = 1;
    try {
      for (; begun < count; ++begun) {
        threads.emplace_back([&, n = begun] { decode(shares[n], inverses[n]); });
      }
    } catch (const std::system_error&) {  // no thread to be had: the rest is done here
    }
    decode(shares[0], inverses[0]);
    for (std::size_t n = begun; n < count; ++n) decode(shares[n], inverses[n]);
    for (std::thread& thread : threads) thread.join();
    for (const Share& share : shares) {
      require(share.sound, "has another number of terms apart than it says");
    }
  }

 private:
  static constexpr std::size_t kLeavesAThread = 128;  // a thread costs as much as a few leaves
  static constexpr unsigned kMostThreads = 4;

  [[nodiscard]] std::size_t leaf_size() const { return LeafTransform::kSamples * phases_; }

  /// The leaves from `first` on; also what lies before them.
  [[nodiscard]] Share share_of(std::size_t first) const {
    Share out;
    out.first = first;
    for (std::size_t leaf = 0; leaf < first; ++leaf) {
      out.apart_at += apart_counts_[leaf];
      for (std::size_t mode = 0; mode < phases_; ++mode) {
        const std::size_t length = lengths_[leaf * phases_ + mode];
        for (std::size_t b = 0; b < kBands && kBandEnds[b] < length; ++b) {
          out.band_at[b] += band_bytes(b, length);
        }
      }
    }
    return out;
  }

  void decode(Share& share, LeafTransform::Inverse& inverse) const noexcept {
    std::array<BandReader, kBands> bands;
    for (std::size_t b = 0; b < kBands; ++b) {
      bands[b] = BandReader(bands_[b].subspan(share.band_at[b]), b);
    }
    std::size_t apart_at = share.apart_at;
    for (std::size_t leaf = share.first; leaf < share.end; ++leaf) {
      ApartReader apart(apart_.subspan(sizeof(std::uint32_t) * apart_at,
                                       sizeof(std::uint32_t) * apart_counts_[leaf]));
      apart_at += apart_counts_[leaf];
      inverse.clear();
      for (int mode = 0; mode < field_.phases; ++mode) {
        const std::size_t length = lengths_[leaf * phases_ + static_cast<std::size_t>(mode)];
        if (length == 0) continue;
        float* to = inverse.mode(mode);
        for (std::size_t b = 0; b < kBands && kBandEnds[b] < length; ++b) {
          bands[b].read(length, transform_.order(), apart, to);
        }
      }
      share.sound = share.sound && apart.is_at_end();
      const double quantum = std::ldexp(quantum_, -std::to_integer<int>(grades_[leaf]));
      inverse.to_coefficients(static_cast<float>(quantum),
                              field_.coefficients.data() + leaf * leaf_size());
    }
  }

  FieldPayload& field_;
  double quantum_;
  std::size_t phases_;
  ByteView grades_;
  std::vector<std::uint16_t> lengths_;       // [leaf][mode]
  std::vector<std::uint32_t> apart_counts_;  // [leaf]
  LeafTransform transform_;
  std::array<ByteView, kBands> bands_;
  ByteView apart_;
};

}  // namespace

void check_field(const FieldPayload& field) {
  check_header(field);
  require(field.blocks.size() == block_total(field), "has a block table of a wrong size");
  std::int32_t next_leaf = 0;
  for (std::int32_t block : field.blocks) {
    if (block == FieldPayload::kOutside || block == FieldPayload::kInside) continue;
    require(block == next_leaf, "has its leaves out of order");
    ++next_leaf;
  }
  require(static_cast<std::uint64_t>(next_leaf) * FieldPayload::kBlockSamples *
                  static_cast<std::uint64_t>(field.phases) ==
              field.coefficients.size(),
          "has another number of coefficients than its blocks say");
}

FieldPayload decode_field(ByteView entry, Structure structure) {
  const Bytes bytes = zstd_unpack(entry);
  ByteReader reader(bytes);
  reader.expect_magic(kFieldMagic);
  require(reader.get<std::uint32_t>() == kFieldVersion, "is of an unknown version");
  FieldPayload field;
  field.structure = structure;
  const auto bounded = [&reader](std::uint32_t limit) {
    return static_cast<int>(std::min(reader.get<std::uint32_t>(), limit + 1));
  };
  field.phases = bounded(kMaxPhases);
  for (int& count : field.block_count) count = bounded(kMaxBlocksAlongAxis);
  Stored stored;
  stored.leaves = reader.get<std::uint32_t>();
  for (int axis = 0; axis < 3; ++axis) field.origin_mm[axis] = reader.get<double>();
  field.voxel_mm = reader.get<double>();
  field.step_mm = reader.get<double>();
  field.inner_mm = reader.get<double>();
  field.outer_mm = reader.get<double>();
  stored.quantum_mm = reader.get<double>();
  stored.apart = reader.get<std::uint32_t>();
  check_header(field);
  require(within(stored.quantum_mm, 1e-6, 10), "has a quantum out of range");

  // Every count is at most what it counts in bytes, so no product below can overflow.
  const std::uint64_t blocks = block_total(field);
  const std::uint64_t rest = reader.remaining();
  constexpr std::uint64_t kLeafBytes = sizeof(std::int16_t) * FieldPayload::kBlockSamples;
  const auto phases = static_cast<std::uint64_t>(field.phases);
  require(
      blocks <= rest && stored.leaves <= rest &&
          blocks + stored.leaves * (1 + sizeof(std::uint16_t) * phases + sizeof(std::uint32_t)) <=
              rest,
      "has counts that its size contradicts");
  require(kLeafBytes * stored.leaves * phases <= plausible_bytes(entry.size()),
          "claims more coefficients than are plausible for its size");

  field.blocks.reserve(static_cast<std::size_t>(blocks));
  std::int32_t leaf_at = 0;
  for (std::byte state : reader.take(static_cast<std::size_t>(blocks))) {
    const auto value = std::to_integer<std::uint8_t>(state);
    require(value <= kStateLeaf, "has an unknown block state");
    field.blocks.push_back(value == kStateLeaf     ? leaf_at++
                           : value == kStateInside ? FieldPayload::kInside
                                                   : FieldPayload::kOutside);
  }
  require(static_cast<std::size_t>(leaf_at) == stored.leaves,
          "has another number of leaves than its blocks say");
  CoefficientDecoder(reader, field, stored).decode();
  check_field(field);
  return field;
}

}  // namespace beatlas::atlas
