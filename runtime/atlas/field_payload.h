#pragma once
/// The bytes of fields/<structure>.field.zst, version 2. One zstd frame that holds, little-endian:
///
///   offset  type      what
///        0  char[8]   kFieldMagic
///        8  u32       kFieldVersion
///       12  u32       phases P
///       16  u32[3]    block_count
///       28  u32       leaf count L
///       32  f64[3]    origin_mm
///       56  f64[4]    voxel_mm, step_mm, inner_mm, outer_mm
///       88  f64       quantum_mm
///       96  u32       count of terms that are written apart, E
///      100  u8[B]     state of each block (B: product of block_count): 0 outside, 1 inside, 2
///                     leaf; the n-th leaf block is leaf n
///           u8[L]     grade of each leaf, 0..kMaxGrade: its quantum is quantum_mm / 2^grade
///           u16[L*P]  length of each leaf's modes: terms of higher rank are 0
///           u32[L]    how many of each leaf's terms are written apart
///           u8[...]   terms, kBands after each other
///           u32[E]    those written apart
///
/// A leaf's coefficients are stored as terms of the transform in field_transform.h, each a whole
/// count. Of a band, ranks kBandEnds[b] to kBandEnds[b + 1] of LeafTransform::order(), all leaves
/// follow each other and all modes of each. A count is zigzag-coded: 0, -1, 1, -2, ... -> 0, 1, 2,
/// 3, ... In the low bands a code is a byte, in those from kFirstPairedBand on half of one, two
/// codes a byte, the first above; the last of an odd number is followed by 0. A code that is larger
/// than what fits is written as the largest (255, 15) and stands among those apart, which are in
/// the order of leaves, then modes, then ranks.

#include "runtime/atlas/bytes.h"
#include "runtime/atlas/field_transform.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::atlas {

inline constexpr std::string_view kFieldMagic{"BEATFLD\0", 8};
inline constexpr std::uint32_t kFieldVersion = 2;
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

/// @throws Error{InvalidInput} if the payload breaks what payloads.h says of its layout, or a
/// number is not finite or out of range: voxel_mm 0.01..100, step_mm 1e-6..10, inner_mm and
/// outer_mm (0, 1000] and at most 32765 steps, |origin_mm| <= 1e5, block_count 1..4096, phases
/// 1..kMaxPhases.
void check_field(const FieldPayload& field);

/// Bytes of the whole entry -> payload. Nothing is allocated before its size is known to be
/// plausible (see zstd_frame.h; coefficients count as unpacked bytes), and the counts of the header
/// must account for every byte. @throws Error{InvalidInput}
[[nodiscard]] FieldPayload decode_field(ByteView entry, Structure structure);

}  // namespace beatlas::atlas
