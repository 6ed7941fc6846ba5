#pragma once
/// A packaged surface at any moment of the beat.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/atlas/payloads.h"
#include "runtime/base/geometry.h"

namespace beatlas::viewer {

/// Vertices between the packaged phases: the periodic cubic spline through them, as smooth in time
/// (C2) as the field that is felt. Immutable; holds its payload.
class SurfaceMotion {
 public:
  /// @param surface as the reader checked it
  /// @throws Error{InvalidInput} if there is none or it has no phase.
  explicit SurfaceMotion(std::shared_ptr<const atlas::SurfacePayload> surface);

  [[nodiscard]] const atlas::SurfacePayload& surface() const noexcept { return *surface_; }
  [[nodiscard]] std::size_t vertex_count() const noexcept;

  /// @param beats time over the R-R interval, any number; phase p is at p / phases
  /// @param to vertex_count() positions, workspace [mm]
  void positions_at(double beats, std::span<Vec3f> to) const noexcept;

  /// Outward unit normals of vertices: mean of their triangles', weighted by area; zero where there
  /// is no area. @param to as many as `positions`
  void normals_of(std::span<const Vec3f> positions, std::span<Vec3f> to) const noexcept;

 private:
  std::shared_ptr<const atlas::SurfacePayload> surface_;
  std::vector<std::vector<Vec3f>> coefficients_;  // [phase][vertex]
};

/// A piece of the line in which a plane cuts a surface.
struct CutSegment {
  Vec3f from_mm;
  Vec3f to_mm;
};

/// Where the plane through `point_mm` cuts the triangles; each piece has the surface's outside on
/// its right, seen against `normal`.
[[nodiscard]] std::vector<CutSegment> cut_surface(
    std::span<const std::array<std::uint32_t, 3>> triangles, std::span<const Vec3f> positions,
    const Vec3& point_mm, const Vec3& normal);

}  // namespace beatlas::viewer
