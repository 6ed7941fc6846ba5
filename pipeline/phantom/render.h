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

/// Images the phantom as its spec's scanner does. Each voxel averages the signals in its box (see
/// cover.h) over the moments of its frame (see acquisition.h), is multiplied by the coil's
/// sensitivity, gets Rician noise of standard deviation blood / snr_blood in each channel and is
/// rounded. All of it follows from the spec alone. Labels know of no degradation: they are those of
/// voxels' centres at the phases' nominal times.
[[nodiscard]] Rendering render(const Phantom& phantom, StageContext& context);

}  // namespace beatlas::phantom
