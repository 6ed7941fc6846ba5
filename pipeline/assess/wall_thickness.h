#pragma once
#include "pipeline/assess/figures.h"
#include "pipeline/phantom/phantom.h"
#include "runtime/field/field_query.h"

namespace beatlas::assess {

struct ThicknessOptions {
  double spacing_mm = 3.0;  ///< [mm] 0.3..20: between points of the true endocardium
  /// >= 0: a ray counts if both of its ends keep this far from the creases of the true wall (the
  /// rim of the base) [mm]; fields round a rim two or three voxels wide.
  double rim_mm = 4.0;
};

/// The length of muscle met along the true outward normal of the endocardium, from points of it
/// whose ray leaves the muscle through the epicardium and not through the base.
/// Truth: exact. Package: from where the ray leaves the field of lv_blood, sought within 12 mm of
/// the true endocardium, to where it leaves that of lv_myocardium, which it must have entered
/// within 5 mm; a ray without these two is missing.
/// @param share of the R-R interval, of the package's and of the truth's own
[[nodiscard]] ThicknessErrors wall_thickness_errors(const field::FieldQuery& blood,
                                                    const field::FieldQuery& muscle,
                                                    const Affine& workspace_from_lps,
                                                    const phantom::Phantom& truth, double share,
                                                    const ThicknessOptions& options);

}  // namespace beatlas::assess
