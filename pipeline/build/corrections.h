#pragma once
/// What was made by hand, as segmentation takes it.

#include <optional>
#include <vector>

#include "pipeline/build/orders.h"
#include "pipeline/core/exam.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/prior/prior.h"
#include "pipeline/segment/given_coverage.h"

namespace beatlas::build {

/// What was marked and segmented by hand, on the grid and in the phases of an exam.
struct Corrections {
  std::vector<segment::Seed> seeds;  ///< drawn and painted
  segment::KnownLabels known;
  segment::GivenCoverage coverage;
};
/// Labels are moved with the exam's slices, in place and time, unless the recipe says otherwise;
/// seeds lie where the study's images show them.
/// @throws Error{InvalidInput} naming the user's file that does not fit
[[nodiscard]] Corrections corrections_for(const Exam& exam, const Orders& orders,
                                          StageContext& context);

/// Labels on the exam's images where and when its slices were imaged, before import moved them;
/// none where it moved none.
[[nodiscard]] std::optional<LabelCycle> labels_as_acquired(const LabelCycle& labels,
                                                           const Exam& exam);

/// Makes labels that were drawn on the exam's images, as a study shows them, such as are drawn on
/// the images as they came: corrections_for moves them there and back to the voxel. Where slices
/// were out of step, one phase becomes parts of several.
/// @param before what was given before: it stands in the other slices of these
void move_back(const Exam& exam, const std::optional<study::GivenLabels>& before,
               study::GivenLabels& given);

/// Labels of some phases, with those of the other phases that were given before: phases are
/// corrected one after the other.
/// @param now of named phases, or of all, which stand alone
/// @throws Error{InvalidInput} if both are not on one grid
[[nodiscard]] study::GivenLabels with_other_phases(study::GivenLabels now,
                                                   const study::GivenLabels& before);

/// Segments an exam with what was made by hand, if anything was.
/// @param prior see segment_exam
[[nodiscard]] Segmentation segment_with(const Exam& exam, const Corrections& corrections,
                                        const segment::SegmentOptions& options,
                                        StageContext& context, const prior::PriorCycle* prior);

}  // namespace beatlas::build
