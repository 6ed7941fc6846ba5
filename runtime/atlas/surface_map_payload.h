#pragma once
/// The bytes of maps/<structure>.map.zst, version 1: one zstd frame of, little-endian,
///
///   offset  type      what
///        0  char[8]   kMapMagic
///        8  u32       kMapVersion
///       12  u32       vertices V
///       16  u32       phases P
///       20  f64       step_mm
///       28  u8[V]     segment, 1..17; of rv_blood 0
///           u8[2][V]     place on the long axis in 1/kMapParts, 0..kMapParts
///           u8[2][V]     angle in turns / kMapParts, 0..kMapParts - 1
///           u8[2][P][V]  thickness in step_mm, 0: no wall; of rv_blood
///                        also where the images do not resolve it
///
/// Vertices are those of surfaces/<structure>.drc in their order. The last three are counts of 16
/// bit less what is foretold, coded 0, -1, 1, -2, ... as 0, 1, 2, 3, ...; first the low bytes of
/// all, then the high ones. Foretold is the count of the vertex before (0 before the first); of
/// thickness in a phase but the first, that and by how much the vertex itself has changed since the
/// phase before more than the vertex before. All modulo 2^16, angles modulo kMapParts.

#include "runtime/atlas/bytes.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::atlas {

inline constexpr std::string_view kMapMagic{"BEATMAP\0", 8};
inline constexpr std::uint32_t kMapVersion = 1;
inline constexpr int kMapParts = 1024;
inline constexpr int kMapSegments = 17;
/// What the encoder takes. A stored thickness is within half a step of what it was, and a wall is
/// never stored as none.
inline constexpr double kThicknessStepMm = 0.05;
inline constexpr double kMaxThicknessErrorMm = 0.5 * kThicknessStepMm;
inline constexpr double kMaxLongAxisError = 0.5 / kMapParts;
inline constexpr double kMaxAngleErrorRad = 3.14159265358979324 / kMapParts;  ///< around the turn
inline constexpr double kThickestMm = 100;

/// @throws Error{InvalidInput} if the map has no vertex or phase, lists of different lengths, a
/// place or an angle out of range, a segment that is none (or, on the RV, one), or a thickness that
/// is negative, no number or above kThickestMm.
void check_surface_map(const SurfaceMapPayload& map);

/// Bytes of the entry -> payload. @throws Error{InvalidInput}
[[nodiscard]] SurfaceMapPayload decode_surface_map(ByteView entry, Structure structure);

/// What both sides foretell. @param before, last, last_before of the vertex before in this phase,
/// of the vertex in the phase before, and of the vertex before in that
[[nodiscard]] constexpr std::uint16_t foretold_thickness(std::uint16_t before, std::uint16_t last,
                                                         std::uint16_t last_before) noexcept {
  return static_cast<std::uint16_t>(before + last - last_before);
}

}  // namespace beatlas::atlas
