#pragma once
/// A structure that is drawn and not felt, an atrium or the aorta, against the truth: the package
/// has a surface of it and no field, so its triangles are asked.

#include "pipeline/assess/compare.h"
#include "pipeline/assess/figures.h"
#include "pipeline/phantom/phantom.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::assess {

/// One phase: vertices of the surface to the exact truth, each with a third of its triangles, and
/// points of the true surface to the triangles; creases of the truth left out. Distances of the
/// truth's points have the sign of the nearest triangle's side.
/// @param p 0 to the surface's number of phases - 1; stands for that share of the R-R interval
/// @return without points where the truth has no such part
[[nodiscard]] DrawnErrors drawn_errors(const atlas::SurfacePayload& surface,
                                       const Affine& workspace_from_lps,
                                       const phantom::Phantom& truth, int p,
                                       const CompareOptions& options);

}  // namespace beatlas::assess
