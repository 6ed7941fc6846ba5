#include "runtime/atlas/leaf_terms.h"

#include <algorithm>
#include <cmath>
#include <system_error>
#include <thread>

namespace beatlas::atlas {
namespace {

constexpr std::size_t kLeavesAThread = 128;  // a thread costs as much as a few leaves
constexpr unsigned kMostThreads = 4;

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

}  // namespace

/// Leaves that one thread decodes.
struct LeafTerms::Share {
  std::size_t first = 0;
  std::size_t end = 0;
  std::array<std::size_t, kBands> band_at{};  ///< where their bytes begin in each band
  std::size_t apart_at = 0;                   ///< in terms
  bool sound = true;
};

void LeafTerms::require(bool ok, const char* what) const {
  if (!ok) throw_invalid(owner_ + " " + what + "; build the package again");
}

LeafTerms::LeafTerms(ByteReader& reader, const Counts& counts, std::string owner)
    : owner_(std::move(owner)),
      phases_(static_cast<std::size_t>(counts.phases)),
      grades_(reader.take(counts.leaves)),
      lengths_(counts.leaves * phases_),
      apart_counts_(counts.leaves) {
  for (const std::byte grade : grades_) {
    require(std::to_integer<int>(grade) <= kMaxGrade, "has a leaf of an unknown grade");
  }
  reader.get_many(lengths_.data(), lengths_.size());
  for (const std::uint16_t length : lengths_) {
    require(length <= LeafTransform::kSamples, "has a mode of too many terms");
  }
  reader.get_many(apart_counts_.data(), apart_counts_.size());
  const Share all = share_of(counts.leaves);
  for (std::size_t b = 0; b < kBands; ++b) bands_[b] = reader.take(all.band_at[b]);
  require(
      all.apart_at == counts.apart && reader.remaining() == sizeof(std::uint32_t) * counts.apart,
      "has counts that its size contradicts");
  apart_ = reader.take(reader.remaining());
}

/// The leaves from `first` on; also what lies before them.
LeafTerms::Share LeafTerms::share_of(std::size_t first) const {
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

void LeafTerms::decode(const LeafTransform& transform, double quantum, std::int16_t* to) const {
  const std::size_t count =
      std::clamp<std::size_t>(grades_.size() / kLeavesAThread, 1,
                              std::clamp(std::thread::hardware_concurrency(), 1U, kMostThreads));
  std::vector<Share> shares;
  for (std::size_t n = 0; n < count; ++n) {
    shares.push_back(share_of(n * grades_.size() / count));
    shares.back().end = (n + 1) * grades_.size() / count;
  }
  std::vector<LeafTransform::Inverse> inverses(count, LeafTransform::Inverse(transform));
  std::vector<std::thread> threads;
  threads.reserve(count);
  std::size_t begun = 1;
  try {
    for (; begun < count; ++begun) {
      threads.emplace_back(
          [&, n = begun] { decode(shares[n], transform, inverses[n], quantum, to); });
    }
  } catch (const std::system_error&) {  // no thread to be had: the rest is done here
  }
  decode(shares[0], transform, inverses[0], quantum, to);
  for (std::size_t n = begun; n < count; ++n) {
    decode(shares[n], transform, inverses[n], quantum, to);
  }
  for (std::thread& thread : threads) thread.join();
  for (const Share& share : shares) {
    require(share.sound, "has another number of terms apart than it says");
  }
}

void LeafTerms::decode(Share& share, const LeafTransform& transform,
                       LeafTransform::Inverse& inverse, double quantum,
                       std::int16_t* to) const noexcept {
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
    for (std::size_t mode = 0; mode < phases_; ++mode) {
      const std::size_t length = lengths_[leaf * phases_ + mode];
      if (length == 0) continue;
      float* terms = inverse.mode(static_cast<int>(mode));
      for (std::size_t b = 0; b < kBands && kBandEnds[b] < length; ++b) {
        bands[b].read(length, transform.order(), apart, terms);
      }
    }
    share.sound = share.sound && apart.is_at_end();
    const double own = std::ldexp(quantum, -std::to_integer<int>(grades_[leaf]));
    inverse.to_coefficients(static_cast<float>(own), to + leaf * leaf_size());
  }
}

}  // namespace beatlas::atlas
