#pragma once
/// A finished segmentation from elsewhere, of all phases or of some.

#include <vector>

#include "pipeline/segment/given_coverage.h"
#include "pipeline/segment/segment.h"

namespace beatlas::segment {

/// All phases known: the labels are taken as they are, with coverage of the smooth
/// body that they could be of or, in thick slices, of their smoothed outlines and flat ends on the
/// base's side (see with_edited_labels). Some
/// known: those stay as given, the others grow in competition from seeds that the known ones,
/// `seeds` and the images give; labels that no known phase has are made in none.
/// @param known on the exam's grid, see labels_on_grid
/// @param coverage of labels of all phases: it tells where in its voxels a structure's surface
/// runs; empty: the labels alone tell
/// @param prior see segment_exam
/// @throws Error{InvalidInput} as check_known; as segment_exam where phases have to be grown; if a
/// structure is there in some phases and not in others; as take_given_coverage; if there is
/// coverage and not every phase is known.
[[nodiscard]] Segmentation segment_with_labels(const Exam& exam, const KnownLabels& known,
                                               const std::vector<Seed>& seeds,
                                               const SegmentOptions& options, StageContext& context,
                                               const GivenCoverage& coverage = {},
                                               const prior::PriorCycle* prior = nullptr);

/// Whether a voxel of a known phase is kLabelUnknown.
[[nodiscard]] bool has_unknown(const KnownLabels& known);

/// @throws Error{InvalidInput} if phases are not ascending phases of the exam, one a label image,
/// or if a phase has no heart.
void check_known(const KnownLabels& known, const Grid& grid, int phases);

}  // namespace beatlas::segment
