#pragma once
/// Where an exam of a heart of the family has its slices and views and when its frames: drawn, and
/// held to a number of voxels.
///
/// Patient frame LPS [mm], origin at the heart's middle, as of drawn_body.h.

#include <string>
#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/phantom/drawn_heart.h"

namespace beatlas::phantom {

struct DrawnStack {
  std::string plane;  ///< "short_axis", "axial", "oblique" or "long_axis"
  Vec3F u = Vec3F::UnitX();
  Vec3F v = Vec3F::UnitY();
  Vec3F normal = Vec3F::UnitZ();
  Vec3F middle = Vec3F::Zero();  ///< of the stack's box
  int columns = 0;               ///< and rows
  int slices = 0;
  /// Slices of the exam before these; noise and shift are functions of which slice it is of all.
  int before = 0;
  float pixel_mm = 0;
  float distance_mm = 0;   ///< from slice to slice
  float thickness_mm = 0;  ///< of a slice, at most the distance
  float rr_interval_s = 0;
  std::vector<float> times;             ///< [phase] share of the beat at which it is taken
  std::vector<Eigen::Vector2f> shifts;  ///< [slice][mm] along u and v: so far the anatomy moved

  /// Voxel centres, LPS; i along u, j along v, k along the normal.
  [[nodiscard]] Grid grid() const;
  /// Centre of a pixel, that of the slice's shift taken into account: what is seen there.
  /// @param i, j, k indices, fractional
  [[nodiscard]] Vec3F seen_at(float i, float j, float k, const Eigen::Vector2f& shift) const;
};

/// @param axes see heart_axes
/// @param most_voxels of all slices and phases; frames go first or pixels grow first, as drawn,
/// then the field of view shrinks to what holds the ventricles
[[nodiscard]] DrawnStack drawn_stack(const Family& family, const DrawnHeart& heart,
                                     const Eigen::Matrix3f& axes, int most_voxels);

/// Long-axis views beside a stack: planes of one slice through the LV's axis, evenly turned about
/// it, the first through the middle of the RV (of two the four- and the two-chamber view), laid by
/// hand and moved by breath-holds. Pixels and times are the stack's.
[[nodiscard]] std::vector<DrawnStack> drawn_views(const Family& family, const DrawnHeart& heart,
                                                  const Eigen::Matrix3f& axes,
                                                  const DrawnStack& stack, int count);

}  // namespace beatlas::phantom
