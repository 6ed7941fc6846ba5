#pragma once
#include <map>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/field/surface.h"

namespace beatlas::keyframes {

/// A heart as closed surfaces at some moments of its beat; patient LPS [mm].
struct KeyHeart {
  double rr_interval_s = 0;  ///< [s] 0.02..20
  int phases = 0;            ///< 3..200 that are made of it, uniform in the R-R interval
  /// Of each key: share of the R-R interval, ascending, 0..below 1; see bounded_spline for what
  /// uneven ones cost.
  std::vector<double> key_at;
  /// [structure][key], three keys or more; of heart (all of it), lv_blood, rv_blood and
  /// lv_myocardium. What of the heart none of the others fills is the LV's muscle if there is
  /// neither rv_blood nor lv_myocardium, else the rest of the heart.
  std::map<Structure, std::vector<field::TriangleSoup>> surfaces;
  double voxel_mm = 1;  ///< [mm] 0.3..5 of the images
};

/// What the surfaces look like in a scanner without faults: each voxel holds what its share of
/// blood, muscle and the outside gives; and the label of each voxel's centre.
struct SeenHeart {
  Exam exam;
  LabelCycle labels;  ///< on the exam's grid, a phase each
};

/// The same bytes for any number of threads.
/// @throws Error{InvalidInput} that names structure and key: no heart, too few keys, a surface that
/// is not closed, a number out of range, more than 3e8 voxels of images and distances;
/// Error{Machine} if stopped.
[[nodiscard]] SeenHeart see_heart(const KeyHeart& heart, StageContext& context);

}  // namespace beatlas::keyframes
