#pragma once
/// One structure of a package against the truth, phase by phase.

#include <memory>

#include "pipeline/assess/figures.h"
#include "pipeline/core/grid.h"
#include "pipeline/phantom/phantom.h"
#include "runtime/atlas/manifest.h"
#include "runtime/field/field_query.h"

namespace beatlas::assess {

struct CompareOptions {
  double crease_band_mm = 2.0;     ///< >= 0: around creases of the truth nothing is measured
  double sample_spacing_mm = 2.0;  ///< [mm] 0.3..20: between points on the true surface
};

/// The source's grid as the manifest says; voxel centres in patient LPS.
[[nodiscard]] Grid source_grid(const atlas::Manifest& manifest);

/// All but the volume, which is the manifest's and not the field's. Phase p of `phases` stands for
/// p / phases of the R-R interval, of the package's and of the truth's own.
[[nodiscard]] PhaseErrors compare_phase(const atlas::Manifest& manifest,
                                        const field::FieldQuery& query,
                                        const phantom::Phantom& truth, int p, int phases,
                                        const CompareOptions& options);

}  // namespace beatlas::assess
