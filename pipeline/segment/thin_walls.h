#pragma once
/// Walls too thin for a prior of pixels of 2 mm: those of the right ventricle, atria and vessels.

#include "pipeline/core/grid.h"
#include "pipeline/segment/levels.h"

namespace beatlas::segment {

/// Around the blood of the RV, the atria and the aorta, what looks like muscle and hangs together
/// with the pool becomes rest of the heart, 5 mm deep at most: a thicker wall of the RV counts as
/// hypertrophy (Rudski 2010, doi:10.1016/j.echo.2010.05.010), and an atrium's is thinner (review:
/// PMC5841556). Fat is brighter than muscle, and lung darker. Slices far apart stand alone.
/// @param images of the labels' grid, evenly lit
void add_thin_walls(const ImageCycle<float>& images, const TissueLevels& levels,
                    ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
