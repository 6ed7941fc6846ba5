#pragma once
/// Sub-voxel edges where a surface runs along the slices.

#include <cstdint>
#include <vector>

#include "pipeline/segment/boundary.h"

namespace beatlas::segment {

/// A voxel whose coverage was settled, and the voxel on the inner side of the surface there.
struct Settled {
  std::uint32_t voxel = 0;
  std::uint32_t within = 0;
};

/// An outline in plane tells nothing of a surface that runs along the slices: there a slice's
/// voxels are all alike, part in and part out, and coverage is what they hold of either side's
/// level. The more level the surface the more counts what is read off the intensities, a mean over
/// a patch of the slice and what a voxel differs from it beyond its noise. Where it is steep, where
/// levels do not differ, where blood comes to the surface without a wall, where another tissue is
/// close by outside and where two slices beyond lies what may not tell the outer level (a mouth, a
/// wall as thin as a slice), nothing changes.
/// @param input of the boundary, slices thinner than kThickSlicesMm
/// @param tissue_level > 0, of the structure in the images as a whole: serves where no whole voxel
/// of it is near
/// @param coverage of find_boundary; changed in voxels whose neighbour across slices is labelled
/// otherwise
/// @return those, with what lies within
std::vector<Settled> cover_along_slices(const BoundaryInput& input, double tissue_level,
                                        std::vector<float>& coverage);

}  // namespace beatlas::segment
