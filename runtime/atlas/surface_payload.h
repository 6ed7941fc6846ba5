#pragma once
/// The bytes of surfaces/<structure>.drc and surfaces/<structure>.motion, version 2.
///
/// .drc: a Draco mesh (bitstream 2.2, edgebreaker, no metadata) of the mean of all phases:
/// positions [mm] alone, quantised with half the motion's step. Vertices are numbered as Draco
/// gives them: the encoder renumbers a surface so, and proves that they come back so; no number is
/// stored.
///
/// .motion, little-endian:
///
///   offset  type      what
///        0  char[8]   kMotionMagic
///        8  u32       kMotionVersion
///       12  u32       vertices V
///       16  u32       triangles
///       20  u32       phases P
///       24  u32       points that are joined, J: Draco parts a vertex at which a surface touches
///                     itself
///       28  f64       step_mm
///       36  u32[J][2] a joined point, ascending, and the lower one, not joined, that it is one
///       with;
///                     vertices are the others in their order
///           u16[P-1][2]  mean magnitude of the counts in each mode, along the normal and along the
///                     tangents, in 1/64, 1..65535
///           u32[64]   how many counts are in each class, see surface_classes.h
///           u8[...]   the counts of each class after each other, zigzag-coded 0, -1, 1, -2, ...:
///                     symbols of Draco's rANS (EncodeSymbols); none of an empty class
///
/// The displacements of a vertex from the mean are terms of the orthonormal Fourier basis of the
/// cycle (cycle_modes), the mean left out. The terms of a mode, a vector each, are foretold as the
/// weighted sum of those of known vertices (surface_order.h); step_mm times three counts, in the
/// frame of the mean surface at the vertex, are what is to be added. Counts run over vertices in
/// coding order, then modes, then rows of the frame.

#include "runtime/atlas/bytes.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::atlas {

inline constexpr std::string_view kMotionMagic{"BEATMOT\0", 8};
inline constexpr std::uint32_t kMotionVersion = 2;
/// The default step. A stored vertex is within a step of where it was, in every phase (the encoder
/// sees to it); root mean square along an axis 0.3 steps, as of rounding to multiples of it.
inline constexpr double kSurfaceStepMm = 0.01;
inline constexpr double kMaxSurfaceErrorMm = 0.01;

/// @throws Error{InvalidInput} if the surface has no phase, vertex or triangle, more than
/// kMaxTriangles, a phase of another vertex count, a position that is not finite or beyond 1e5 mm,
/// a triangle that uses a vertex twice or one that is not there, or a vertex that no triangle uses.
void check_surface(const SurfacePayload& surface);
inline constexpr std::size_t kMaxTriangles = std::size_t{1} << 24;

/// Bytes of both entries -> payload. @throws Error{InvalidInput}
[[nodiscard]] SurfacePayload decode_surface(ByteView drc, ByteView motion, Structure structure);

/// What Draco gives: a point is a vertex, or a part of one.
struct BaseSurface {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Vec3f> positions;
};
/// @throws Error{InvalidInput} unless it has so many points and triangles
[[nodiscard]] BaseSurface decode_base(ByteView drc, std::uint64_t points, std::uint32_t triangles);

/// A joined point and the one that it is one with.
using JoinedPoints = std::vector<std::array<std::uint32_t, 2>>;
/// The surface of vertices. @throws Error{InvalidInput} if a pair is none that the layout allows
[[nodiscard]] BaseSurface join_points(BaseSurface points, const JoinedPoints& joined);

/// Terms of all modes but the mean's -> displacement in each phase; encoder and decoder share it.
class MotionBasis {
 public:
  explicit MotionBasis(int phases);
  /// @param terms of a vertex, [mode - 1]
  [[nodiscard]] Vec3f at(const Vec3f& mean_mm, const Vec3* terms, int phase) const noexcept;
  /// Displacements from mean_mm [phase] -> terms [mode - 1].
  void analyse(const Vec3* displacement_mm, Vec3* terms) const noexcept;
  [[nodiscard]] std::size_t modes() const noexcept { return phases_ - 1; }

 private:
  std::size_t phases_;
  std::vector<double> weights_;  ///< [mode][phase]
};

}  // namespace beatlas::atlas
