#pragma once
/// How well the place of a surface is known.

#include <optional>

#include "runtime/atlas/manifest.h"

namespace beatlas::atlas {

/// Half of the width of the band about a surface in which the true one lies with a probability of
/// 90 %: of the surfaces of drawn hearts, at end-diastole and end-systole, nine tenths lie no
/// farther from the true one. It bounds the error of one place at a time, and no whole outline.
///
/// Let k be the place's slice, fractional, n the surface's normal and a the angle between n and the
/// slices' normal. Then it is
///
///   across(k) sin a + along(k) |cos a|,
///
/// both of SurfaceBand, linear between slices and beyond the last one as there.
class BandQuery {
 public:
  /// @param manifest of a package with the structure's band
  BandQuery(const Manifest& manifest, SurfaceBand band);

  /// @param place, normal of a surface in the workspace [mm, unit]  @param share_of_cycle a time
  /// over the R-R interval, any number; between two phases the width is between theirs
  /// @return [mm] finite, also where a place or time is not
  [[nodiscard]] double half_width_mm(const Vec3& place, const Vec3& normal,
                                     double share_of_cycle) const;

 private:
  [[nodiscard]] double in_phase(const Vec3& place, const Vec3& normal, std::size_t phase) const;

  SurfaceBand band_;
  Eigen::RowVector4d slice_from_workspace_;
  Vec3 across_slices_;  ///< the slices' normal in the workspace
};

/// Of the structure; none if the package tells no band of it.
[[nodiscard]] std::optional<BandQuery> band_query(const Manifest& manifest, Structure structure);

}  // namespace beatlas::atlas
