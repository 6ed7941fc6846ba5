#pragma once
/// The bytes of surfaces/<structure>.drc and surfaces/<structure>.motion.zst, version 1.
///
/// .drc: a Draco mesh (bitstream 2.2, edgebreaker, no metadata) of the first phase: positions [mm]
/// quantised with a step (kSurfaceStepMm unless told otherwise), and a generic uint32 attribute
/// that holds each vertex's id, because Draco reorders vertices. Ids are 0..V-1, each used.
///
/// .motion.zst: one zstd frame that holds, little-endian:
///
///   offset  type      what
///        0  char[8]   kMotionMagic
///        8  u32       kMotionVersion
///       12  u32       vertices V
///       16  u32       triangles
///       20  u32       phases P, the first one included
///       24  f64       step_mm
///       32  u8[N]     low bytes of the residuals, N = (P - 1) * 3 * V
///           u8[N]     high bytes
///
/// The displacement of vertex v from the first phase is step_mm times a count. Residuals run over
/// phases, then x y z, then vertices: the count's difference from the phase before, less the mean
/// of that difference over the vertex's neighbours of lower id (rounded towards 0), mod 2^16 and
/// zigzag-coded.

#include "runtime/atlas/bytes.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::atlas {

inline constexpr std::string_view kMotionMagic{"BEATMOT\0", 8};
inline constexpr std::uint32_t kMotionVersion = 1;
/// The default step: both codes round to multiples of it along each axis, so a stored vertex is at
/// most sqrt(3) / 2 * 0.01 = 0.0087 mm from where it was.
inline constexpr double kSurfaceStepMm = 0.01;
inline constexpr double kMaxSurfaceErrorMm = 0.01;

/// @throws Error{InvalidInput} if the surface has no phase, vertex or triangle, more than
/// kMaxTriangles, a phase of another vertex count, a position that is not finite or beyond 1e5 mm,
/// a triangle that uses a vertex twice or one that is not there, or a vertex that no triangle uses.
void check_surface(const SurfacePayload& surface);
inline constexpr std::size_t kMaxTriangles = std::size_t{1} << 24;

/// Bytes of both entries -> payload; order of triangles as Draco gives it, ids as they were.
/// @throws Error{InvalidInput}
[[nodiscard]] SurfacePayload decode_surface(ByteView drc, ByteView motion, Structure structure);

/// The first phase alone, for the encoder of `pack`, which measures displacements from what the
/// decoder will see. @throws Error{InvalidInput}
struct BaseSurface {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Vec3f> positions;  ///< by vertex id
};
[[nodiscard]] BaseSurface decode_base(ByteView drc, std::uint32_t vertices,
                                      std::uint32_t triangles);

/// Predicts a vertex from its neighbours of lower id.
class VertexPredictor {
 public:
  VertexPredictor(const std::vector<std::array<std::uint32_t, 3>>& triangles,
                  std::size_t vertex_count);
  /// Mean of `values` over the neighbours of lower id; 0 without any.
  [[nodiscard]] std::int32_t predict(std::size_t vertex,
                                     const std::vector<std::int32_t>& values) const noexcept;

 private:
  std::vector<std::uint32_t> first_;  ///< [vertex] start of its neighbours, and the end
  std::vector<std::uint32_t> neighbours_;
};

}  // namespace beatlas::atlas
