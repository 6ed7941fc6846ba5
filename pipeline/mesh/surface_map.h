#pragma once
/// What a place of the LV's wall is called and how thick the wall is there, vertex by vertex.

#include <vector>

#include "pipeline/core/long_axis.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/surface_map.h"

namespace beatlas::mesh {

/// The long axis and the directions across it in the workspace.
struct LvFrame {
  Vec3 origin_mm = Vec3::Zero();
  Vec3 towards_base = Vec3::UnitZ();
  Vec3 anterior = Vec3::UnitY();  ///< unit, across the axis
  Vec3 septal = Vec3::UnitX();    ///< unit, across both
  double apex_mm = 0;             ///< height of the wall's apical end in the first phase
  double base_mm = 0;             ///< of the base plane
};

/// The septum's middle lies towards the right ventricle's centre; of the two directions across it
/// and the axis the anterior wall's is the one more to the front and above in the patient (the
/// segments' names follow the ventricles, not the patient's axes: Cerqueira et al. 2002).
/// @param rv_centre_mm workspace, mean of the RV surface in the first phase
[[nodiscard]] LvFrame lv_frame(const LongAxis& axis, const Affine& workspace_from_lps,
                               const Vec3& rv_centre_mm);

/// Maps of lv_blood and lv_myocardium, in this order; empty where either surface is missing.
/// Thickness of a vertex on the endocardium is the way along its normal through the distances of
/// lv_myocardium; on the epicardium it is the way to the nearest triangle of lv_blood, which is a
/// normal of the endocardium.
/// @param fields, surfaces of one study
[[nodiscard]] std::vector<SurfaceMap> surface_maps(const std::vector<FieldCycle>& fields,
                                                   const std::vector<SurfaceCycle>& surfaces,
                                                   const LvFrame& frame);

}  // namespace beatlas::mesh
