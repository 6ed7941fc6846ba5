#pragma once
/// The basal end of the LV in thin slices, where an axis is known.

#include "pipeline/segment/chambers.h"

namespace beatlas::segment {

/// Makes rest of the heart of what smoothing carried beyond the LV's base plane into an atrium and,
/// where there is none and the cavity ends openly, of voxels that are half blood and look like a
/// film of muscle across its mouth.
void cut_at_base(const Chambers& chambers, ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
