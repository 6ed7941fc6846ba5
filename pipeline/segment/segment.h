#pragma once
/// Exam -> labels and sub-voxel coverage of the heart's structures, by seeded region growing in
/// competition, foreground against background, through all phases.

#include <string>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::segment {

/// A place a technician marked: a ball of one label in one phase.
struct Seed {
  std::uint8_t label = 0;  ///< see atlas Label; 0 is background
  Vec3 lps_mm = Vec3::Zero();
  double radius_mm = 2.0;
  int phase = 0;  ///< phase it was drawn in; -1 = every phase
};

struct SegmentOptions {
  double min_motion = 0.0;  ///< reserved for the tuning of automatic seeds
};

/// @param seeds empty = automatic: the heart is what moves at the heart rate
/// @throws Error{InvalidInput} if no heart is found, saying what was looked for.
[[nodiscard]] Segmentation segment_exam(const Exam& exam, const std::vector<Seed>& seeds,
                                        const SegmentOptions& options, StageContext& context);

/// Enclosed volume [ml] of a structure in every phase, from coverage.
[[nodiscard]] std::vector<double> volume_curve_ml(const CoverageCycle& coverage,
                                                  Structure structure);

}  // namespace beatlas::segment
