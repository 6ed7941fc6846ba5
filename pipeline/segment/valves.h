#pragma once
/// Ventricle or atrium? In stacks of thick slices the valve planes pass between slices, and blood
/// is blood on both sides.

#include <map>

#include "pipeline/core/shapes.h"
#include "pipeline/segment/chambers.h"

namespace beatlas::segment {

struct ValveOptions {
  /// Systolic excursion of the tricuspid plane in a heart whose LV is kLvLengthMm long
  /// (TAPSE 22 mm; physiology: 16..30), and that length (98 mm: apex to base plane of the phantom).
  double tricuspid_excursion_mm = 22;
  double lv_length_mm = 98;
};

/// Where no beating pool lies beyond the LV's rings, nothing is parted: the LV ends flat half a gap
/// beyond the last slice with its label, a plane that descends in proportion to the LV's volume
/// loss (least squares over the phases). Where one does, the LV ends flat half a gap beyond its
/// most basal ring, and beyond that ring every heart voxel becomes rest of heart. The RV has no
/// ring of muscle that would show where it ends: its plane lies half a gap beyond its most basal
/// slice at end-diastole and descends with the LV's volume loss by the tricuspid excursion, scaled
/// to the heart's length; RV voxels of slices that it has passed become rest of heart (right
/// atrium). Does nothing where slices are thin: then the image shows where the ventricles end.
/// @return the cuts, slice indices in the labels' grid
[[nodiscard]] std::map<Structure, BaseCut> part_ventricles_from_atria(
    ImageCycle<std::uint8_t>& labels, const Chambers& chambers, const ValveOptions& options);

}  // namespace beatlas::segment
