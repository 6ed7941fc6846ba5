#pragma once
/// What a place of the ventricles' walls is called and how thick the wall is there, vertex by
/// vertex.

#include <optional>
#include <vector>

#include "pipeline/core/long_axis.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/surface_map.h"

namespace beatlas::mesh {

/// What maps are measured by, in the workspace: the LV's long axis, the directions across it, the
/// RV's base and the images' voxels.
struct MapFrame {
  Vec3 origin_mm = Vec3::Zero();
  Vec3 towards_base = Vec3::UnitZ();
  Vec3 anterior = Vec3::UnitY();   ///< unit, across the axis
  Vec3 septal = Vec3::UnitX();     ///< unit, across both
  double apex_mm = 0;              ///< height of the wall's apical end in the first phase
  double base_mm = 0;              ///< of the base plane
  std::vector<double> rv_base_mm;  ///< [phase] height of the tricuspid plane; empty: not known
  Vec3 voxel_mm = Vec3::Zero();    ///< of the images, along the workspace's axes

  [[nodiscard]] double height_mm(const Vec3& mm) const {
    return (mm - origin_mm).dot(towards_base);
  }
};

/// The septum's middle lies towards the right ventricle's centre; of the two directions across it
/// and the axis the anterior wall's is the one more to the front and above in the patient (the
/// segments' names follow the ventricles, not the patient's axes: Cerqueira et al. 2002). None
/// without an axis that tells of a right ventricle.
/// @param voxel_mm of the images, along the workspace's axes
[[nodiscard]] std::optional<MapFrame> map_frame(const std::optional<LongAxis>& axis,
                                                const Affine& workspace_from_lps,
                                                const Vec3& voxel_mm);

/// The map of `structure`, lv_blood, lv_myocardium or rv_blood; none without its surface or the
/// distances of lv_myocardium. Thickness of a vertex on the LV's endocardium is the way along its
/// normal through these; on the epicardium it is the way to the nearest triangle of lv_blood (none
/// without), which is a normal of the endocardium. On the RV's endocardium it is that of the free
/// wall, see rv_wall.h, and there are no segments.
/// @param fields, surfaces of one study, those named at least
[[nodiscard]] std::optional<SurfaceMap> surface_map(Structure structure,
                                                    const std::vector<FieldCycle>& fields,
                                                    const std::vector<SurfaceCycle>& surfaces,
                                                    const MapFrame& frame);

}  // namespace beatlas::mesh
