#pragma once
/// The published method (Nakao et al., MEDINFO 2001) as a candidate beside our own: the digitised
/// grid itself, and force interpolated between frames.

#include <memory>

#include "pipeline/assess/touch.h"
#include "pipeline/core/shapes.h"

namespace beatlas::assess {

/// A voxel of the image's grid is heart or not; a user point in a heart voxel touches (nearest
/// voxel). The passive force is proportional to the distance of the user point from the surface:
/// the paper gives no rule for the contact point of a surface that moves, and here it is the
/// nearest point of the voxels' outer faces. Force at the two stored frames around, interpolated
/// linearly.
class VoxelModel {
 public:
  /// @param labels on the source's grid, perpendicular axes
  /// @throws Error{InvalidInput} if there is no phase.
  VoxelModel(std::shared_ptr<const LabelCycle> labels, Structure structure,
             const Affine& workspace_from_lps, double rr_interval_s, double stiffness_n_per_m);

  /// Before a cap; depth, distance and normal of the interpolated force as TwoStepModel's
  /// Published.
  [[nodiscard]] haptics::Contact contact(const Vec3& x, double t_s) const;

 private:
  struct Foot {
    double distance_mm = 0;
    Vec3 normal = Vec3::Zero();
  };
  [[nodiscard]] Foot foot(const Vec3& index, std::size_t phase) const;
  [[nodiscard]] bool inside(int i, int j, int k, std::size_t phase) const;

  std::shared_ptr<const LabelCycle> labels_;
  Structure structure_;
  double rr_interval_s_;
  double stiffness_n_per_m_;
  Affine index_from_workspace_;
  Eigen::Matrix3d workspace_axes_;  ///< unit vectors along i, j, k
  Vec3 spacing_mm_;
};

[[nodiscard]] MakeTouch touch_of(std::shared_ptr<const VoxelModel> model);

}  // namespace beatlas::assess
