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
///           the terms of the leaves' coefficients, see leaf_terms.h: of a leaf, grade 0 has
///                     quantum_mm

#include "runtime/atlas/bytes.h"
#include "runtime/atlas/leaf_terms.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::atlas {

inline constexpr std::string_view kFieldMagic{"BEATFLD\0", 8};
inline constexpr std::uint32_t kFieldVersion = 2;

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
