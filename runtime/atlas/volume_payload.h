#pragma once
/// The bytes of volumes/heart.volume.zst, version 1. One zstd frame that holds, little-endian:
///
///   offset  type      what
///        0  char[8]   kVolumeMagic
///        8  u32       kVolumeVersion
///       12  u32       phases P
///       16  u32[3]    size; blocks B = the product of its eighths, rounded up
///       28  f64[12]   workspace_from_index, 3 x 4, row-major
///      124  f64[2]    offset, step
///      140  f64       quantum, of grade 0
///      148  f64       noise
///      156  u32       count of terms that are written apart
///      160            the terms of the B blocks' counts, see leaf_terms.h

#include "runtime/atlas/bytes.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::atlas {

inline constexpr std::string_view kVolumeMagic{"BEATVOL\0", 8};
inline constexpr std::uint32_t kVolumeVersion = 1;
inline constexpr int kMaxVolumeEdge = 4096;

/// @throws Error{InvalidInput} if the payload breaks what payloads.h says of its layout, or a
/// number is not finite or out of range: size 1..kMaxVolumeEdge, phases 1..kMaxPhases, entries of
/// the map up to 1e6 and its determinant at least 1e-9, |offset| <= 1e9, step 1e-9..1e9, noise
/// 0..1e9.
void check_volume(const VolumePayload& volume);

/// Bytes of the whole entry -> payload. Nothing is allocated before its size is known to be
/// plausible (see zstd_frame.h; counts count as unpacked bytes), and the counts of the header must
/// account for every byte. @throws Error{InvalidInput}
[[nodiscard]] VolumePayload decode_volume(ByteView entry);

}  // namespace beatlas::atlas
