#pragma once
/// How the terms of leaves (field_transform.h) are written; fields and volumes share it. Of L
/// leaves and P phases, at the end of an unpacked payload, little-endian:
///
///           u8[L]     grade of each leaf, 0..kMaxGrade: its quantum is quantum / 2^grade
///           u16[L*P]  length of each leaf's modes: terms of higher rank are 0
///           u32[L]    how many of each leaf's terms are written apart
///           u8[...]   terms, kBands after each other
///           u32[E]    those written apart
///
/// A leaf's coefficients are stored as terms of the transform, each a whole count. Of a band, ranks
/// kBandEnds[b] to kBandEnds[b + 1] of LeafTransform::order(), all leaves follow each other and all
/// modes of each. A count is zigzag-coded: 0, -1, 1, -2, ... -> 0, 1, 2, 3, ... In the low bands a
/// code is a byte, in those from kFirstPairedBand on half of one, two codes a byte, the first
/// above; the last of an odd number is followed by 0. A code that is larger than what fits is
/// written as the largest (255, 15) and stands among those apart, which are in the order of leaves,
/// then modes, then ranks.

#include <array>
#include <string>
#include <vector>

#include "runtime/atlas/bytes.h"
#include "runtime/atlas/field_transform.h"

namespace beatlas::atlas {

inline constexpr int kMaxGrade = 7;

/// Where bands begin and end; the few lowest terms are large, the many high ones mostly 0.
inline constexpr std::array<std::size_t, 14> kBandEnds{0,  1,   4,   10,  20,  35,  56,
                                                       84, 120, 165, 220, 300, 400, 512};
inline constexpr std::size_t kBands = kBandEnds.size() - 1;
inline constexpr std::size_t kFirstPairedBand = 6;
inline constexpr std::uint32_t kApartByte = 255;
inline constexpr std::uint32_t kApartHalf = 15;

/// Bytes in band b of a mode of `length` terms.
[[nodiscard]] constexpr std::size_t band_bytes(std::size_t b, std::size_t length) noexcept {
  const std::size_t end = std::min(length, kBandEnds[b + 1]);
  if (end <= kBandEnds[b]) return 0;
  const std::size_t terms = end - kBandEnds[b];
  return b < kFirstPairedBand ? terms : (terms + 1) / 2;
}

/// The least bytes that so many leaves take. @pre the product fits 64 bits
[[nodiscard]] constexpr std::uint64_t least_term_bytes(std::uint64_t leaves,
                                                       std::uint64_t phases) noexcept {
  return leaves * (1 + sizeof(std::uint16_t) * phases + sizeof(std::uint32_t));
}

/// The terms of a payload's leaves: views of its bytes, and where each leaf's begin.
class LeafTerms {
 public:
  struct Counts {
    std::size_t leaves = 0;
    int phases = 0;         ///< 1..kMaxPhases
    std::size_t apart = 0;  ///< E
  };

  /// Takes all that is left of `reader`.
  /// @param owner "field", "volume", for messages
  /// @pre least_term_bytes of the counts are there
  /// @throws Error{InvalidInput} unless grades and lengths are in range and the bytes are as many
  /// as the counts say.
  LeafTerms(ByteReader& reader, const Counts& counts, std::string owner);

  /// Coefficients of every leaf, kBlockSamples * phases each, [z][y][phase][x]; on up to four
  /// threads, the same whatever their number.
  /// @param quantum of grade 0, in counts of the payload's step
  /// @param to room for all of them
  /// @throws Error{InvalidInput} if a leaf has another number of terms apart than it says.
  void decode(const LeafTransform& transform, double quantum, std::int16_t* to) const;

 private:
  struct Share;
  [[nodiscard]] Share share_of(std::size_t first) const;
  void decode(Share& share, const LeafTransform& transform, LeafTransform::Inverse& inverse,
              double quantum, std::int16_t* to) const noexcept;
  [[nodiscard]] std::size_t leaf_size() const { return LeafTransform::kSamples * phases_; }
  void require(bool ok, const char* what) const;

  std::string owner_;
  std::size_t phases_;
  ByteView grades_;
  std::vector<std::uint16_t> lengths_;       ///< [leaf][mode]
  std::vector<std::uint32_t> apart_counts_;  ///< [leaf]
  std::array<ByteView, kBands> bands_;
  ByteView apart_;
};

}  // namespace beatlas::atlas
