#pragma once
/// The left ventricle's long axis and its base plane, in a stack of thin slices of any direction.

#include <optional>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::segment {

struct Chambers;

/// Patient LPS [mm]. Heights are along `towards_base` from `origin_mm`, which lies in
/// mid-ventricle.
struct LongAxis {
  Vec3 origin_mm = Vec3::Zero();
  Vec3 towards_base = Vec3::UnitZ();  ///< of length 1
  double apex_mm = 0;                 ///< height of the wall's apical end at end-diastole
  std::vector<double> lv_base_mm;     ///< [phase] height at which the ring of muscle opens
  std::vector<double> rv_base_mm;     ///< [phase] height of the tricuspid plane, placed by rule

  bool atria = false;  ///< blood lies beyond the LV's base, and has to be parted from it

  [[nodiscard]] double height_mm(const Vec3& lps_mm) const {
    return towards_base.dot(lps_mm - origin_mm);
  }
  /// Height of every voxel of a grid.
  [[nodiscard]] std::vector<float> heights_mm(const Grid& grid) const;
};

/// The stack is cut again across the ventricle, and the ring of muscle followed from its middle to
/// where it opens (less than half of the rays meet a wall: the technicians' rule), in every phase.
/// The tricuspid valve opens into no such ring: its plane lies with the LV's at end-diastole and
/// descends with it, by `tricuspid_excursion_mm` scaled as in valves.h.
/// None without a left ventricle, in thick slices, or where the ring cannot be followed.
[[nodiscard]] std::optional<LongAxis> find_long_axis(const ImageCycle<float>& images,
                                                     const Chambers& chambers,
                                                     double tricuspid_excursion_mm);

/// The same images in slices across the axis, from below the apex to beyond the atria: there the
/// ventricles look as chambers.h knows them, however the stack was cut. Linear in space, 0 outside.
[[nodiscard]] ImageCycle<float> across_axis(const ImageCycle<float>& images, const LongAxis& axis);

}  // namespace beatlas::segment
