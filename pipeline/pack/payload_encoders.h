#pragma once
/// Payloads -> the bytes of their entries, decoded again before they are returned; the layouts
/// stand beside the decoders, in runtime/atlas/*_payload.h. The same
/// payload gives the same bytes.

#include "runtime/atlas/bytes.h"
#include "runtime/atlas/payloads.h"
#include "runtime/atlas/surface_payload.h"

namespace beatlas::pack {

/// One zstd frame that says how much it holds.
[[nodiscard]] atlas::Bytes zstd_pack(const atlas::Bytes& bytes);

/// Distances at samples and phases within kMostErrorSteps of step_mm; leaves that a first try
/// stores worse are quantised more finely.
/// @param step_mm field_step_mm of the options
/// @throws Error{InvalidInput} if the payload breaks its own layout (see check_field) or cannot be
/// stored that well; Error{Usage} if the step is out of range.
[[nodiscard]] atlas::Bytes pack_field(const atlas::FieldPayload& field, double step_mm);

struct PackedSurface {
  atlas::Bytes drc;
  atlas::Bytes motion;
  /// [stored vertex] its number in the surface that was given. Whatever else goes by vertex is to
  /// be stored in this order.
  std::vector<std::uint32_t> given;
};
/// Positions within step_mm in every phase, the same triangles; vertices renumbered as Draco gives
/// them back, triangles in another order and turned.
/// @param step_mm EncodeOptions::surface_step_mm
/// @throws Error{InvalidInput} if the surface breaks its layout (see check_surface), a vertex moves
/// by more than 32767 steps, or what was packed does not decode to the same triangles within that
/// error; Error{Usage} if the step is out of range.
[[nodiscard]] PackedSurface pack_surface(const atlas::SurfacePayload& surface,
                                         double step_mm = atlas::kSurfaceStepMm);

/// Thickness within kMaxThicknessErrorMm (walls thinner than a step become one), places and angles
/// within their largest errors, segments as they are; see runtime/atlas/surface_map_payload.h.
/// @param map of the surface as it was given  @param given PackedSurface::given of that surface
/// @throws Error{InvalidInput} if the map breaks its layout (see check_surface_map) or is not of so
/// many vertices
[[nodiscard]] atlas::Bytes pack_surface_map(const atlas::SurfaceMapPayload& map,
                                            const std::vector<std::uint32_t>& given);

}  // namespace beatlas::pack
