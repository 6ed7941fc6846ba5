#pragma once
/// Region growing from what a prior knows: it says where the heart is, the images say where its
/// edges are, and both are one price for each label in each voxel.

#include "pipeline/prior/prior.h"
#include "pipeline/segment/segment.h"

namespace beatlas::segment {

/// Whether a prior takes part in what segment_exam makes: one was given, and it holds a heart.
[[nodiscard]] bool prior_tells(const prior::PriorCycle* prior, const SegmentOptions& options);

/// As segment_exam. Labels known in some phases hold there, see known_ground.h.
/// @param prior of this exam's stack
/// @throws Error{InvalidInput} if it holds no heart, or the exam one phase alone
[[nodiscard]] Segmentation segment_from_prior(const Exam& exam, const std::vector<Seed>& given,
                                              const SegmentOptions& options,
                                              const KnownLabels& known,
                                              const prior::PriorCycle& prior,
                                              StageContext& context);

/// The same from a person's seeds alone, see seed_ground.h.  @pre tell_heart(given)
/// @throws Error{InvalidInput} as check_seeds; if muscle is marked on what is as bright as blood
[[nodiscard]] Segmentation segment_from_seeds(const Exam& exam, const std::vector<Seed>& given,
                                              const SegmentOptions& options, StageContext& context);

}  // namespace beatlas::segment
