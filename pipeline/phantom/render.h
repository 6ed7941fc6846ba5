#pragma once
#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/phantom/phantom.h"

namespace beatlas::phantom {

struct Rendering {
  Cine cine;          ///< whole counts 0..4095, blood 1000; grid: spec.imaging_grid(), LPS
  LabelCycle labels;  ///< truth, by the centre of each voxel
};

/// Counts of blood; every signal is scaled to it.
inline constexpr double kBloodCounts = 1000.0;

/// Images the phantom: each voxel averages the signals in its box (slice_thickness_mm along k, see
/// cover.h), then gets Rician noise of standard deviation blood / snr_blood in each channel and is
/// rounded. Noise depends on seed, phase and voxel only, so on nothing else than the spec.
[[nodiscard]] Rendering render(const Phantom& phantom, StageContext& context);

}  // namespace beatlas::phantom
