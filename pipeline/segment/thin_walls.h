#pragma once
/// Walls too thin for a prior of pixels of 2 mm: those of the right ventricle, atria and vessels.

#include "pipeline/core/grid.h"
#include "pipeline/tissue/levels.h"

namespace beatlas::segment {

/// Around the blood of the RV, the atria and the aorta, what looks like muscle and hangs together
/// with the pool becomes rest of the heart, 5 mm deep at most: a thicker wall of the RV counts as
/// hypertrophy (Rudski 2010, doi:10.1016/j.echo.2010.05.010), and an atrium's is thinner (review:
/// PMC5841556). Fat is brighter than muscle, and lung darker. Slices far apart stand alone.
/// @param images of the labels' grid, evenly lit
void add_thin_walls(const ImageCycle<float>& images, const tissue::TissueLevels& levels,
                    ImageCycle<std::uint8_t>& labels);

/// The RV, the atria and the aorta reach as far as their blood is seen: what is rest of the heart,
/// lies within `pixel_mm` of one of them, and is nearer to its blood than to muscle becomes that
/// cavity. A prior tells no outline better than by its pixel, its rest of the heart holds vessels
/// as bright as blood beside walls, and smooth outlines round off the RV's horns. Of 64 drawn
/// stacks of thick slices (9000 to 9079) the RV lacked 13 % at end-diastole without it.
/// @param images of the labels' grid, evenly lit
/// @param pixel_mm of what told where labels are: the prior's, or, of marks, the images'
void reach_walls(const ImageCycle<float>& images, const tissue::TissueLevels& levels,
                 double pixel_mm, ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
