#pragma once
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::segment {

/// A segmentation with other labels in place of its own.
///
/// Where labels changed, and two pixels around, coverage becomes that of the new labels' own
/// smoothed outlines, or of their smooth surface (smooth_coverage) where slices are thin and a
/// phase had no labels before; elsewhere it stays as made. The plane of a base moves out as far as
/// labels of its structure were painted beyond it. End-diastole and end-systole follow; alarms are
/// to be asked for anew.
/// @param made as segment_exam gave it; @param labels on its grid, one image a phase
/// @throws Error{InvalidInput} if a label is unknown, if there is no heart left, or if a structure
/// is there in some phases and not in others.
[[nodiscard]] Segmentation with_other_labels(Segmentation made, const LabelCycle& labels,
                                             StageContext& context);

/// The same for labels that were painted over in another program; a warning tells of them.
[[nodiscard]] Segmentation with_edited_labels(Segmentation made, const LabelCycle& labels,
                                              StageContext& context);

}  // namespace beatlas::segment
