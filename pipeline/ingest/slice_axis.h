#pragma once
/// Along which axis of an image file the slices follow one another. Scanners write it last; tools
/// that turn an image towards the patient's axes put it wherever it then falls.

#include "pipeline/core/grid.h"

namespace beatlas::ingest {

/// The axis (0..2) whose spacing is the largest and stands apart from the two others, which are
/// more alike, if it also has the fewest voxels; else 2, as scanners write.
[[nodiscard]] int slice_axis(const Grid& grid);

/// The same voxels at the same places with `axis` as the third; the three keep their cyclic order,
/// and with it the grid's handedness. @param axis 0..2
void put_axis_last(ImageCycle<float>& images, int axis);

}  // namespace beatlas::ingest
