#pragma once
/// The phantom as the sweep wants it: with another matrix, or as a shape without any image.

#include <vector>

#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/phantom/phantom.h"

namespace beatlas::assess {

/// The same field of view in `factor` times as many voxels along each axis (rounded), with slices
/// as thick in proportion. @param factor 0.1..10
[[nodiscard]] phantom::PhantomSpec scaled_matrix(phantom::PhantomSpec spec, double factor);

/// What registration would give if segmentation made no error: the closed form's signed distance on
/// an isotropic lattice of the workspace, in every phase. Exact within five samples of the surface,
/// beyond that clamped to five samples, which the field stage does not look at.
/// @param sample_mm, margin_mm as RegisterOptions
[[nodiscard]] ShapeCycle exact_shape(const phantom::Phantom& phantom, Structure structure,
                                     const Affine& workspace_from_lps, double sample_mm,
                                     double margin_mm, StageContext& context);

}  // namespace beatlas::assess
