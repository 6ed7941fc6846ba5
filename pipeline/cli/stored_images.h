#pragma once
#include "pipeline/core/grid.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::cli {

/// The images that a package's volume gives back, on the source's grid where they lie on it, 0
/// beyond the volume; else on a grid of their own. LPS. Where whole numbers are far finer than the
/// noise, intensities are rounded to them.
[[nodiscard]] ImageCycle<float> images_of(const atlas::VolumePayload& volume,
                                          const Grid& lps_source, const Affine& workspace_from_lps);

}  // namespace beatlas::cli
