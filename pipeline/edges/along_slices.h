#pragma once
/// Sub-voxel edges where a surface runs along the slices.

#include <cstdint>
#include <vector>

#include "pipeline/edges/boundary.h"

namespace beatlas::edges {

/// A voxel whose coverage was settled, and the voxel on the inner side of the surface there.
struct Settled {
  std::uint32_t voxel = 0;
  std::uint32_t within = 0;
};

/// Of a structure and what lies around it.
struct Sides {
  double inner_level = 0;  ///< > 0, serves where no whole voxel that tells it is near
  double outer_level = 0;  ///< the same; 0: nothing is changed there
  /// What a cavity's wall is of: where the next voxel is none of it, or what follows is of it and
  /// does not tell the outer level, no wall ends the cavity. May be null.
  const std::vector<std::uint8_t>* walls = nullptr;
};

/// An outline in plane tells nothing of a surface that runs along the slices: there a slice's
/// voxels are all alike, part in and part out, and coverage is what they hold of either side's
/// level. The more level the surface the more counts what is read off the intensities, a mean over
/// a patch of the slice and what a voxel differs from it beyond its noise. Where it is steep, where
/// levels do not differ, where blood comes to the surface without a wall and where another tissue
/// is close by outside, nothing changes.
/// @param input of the boundary, slices thinner than kThickSlicesMm
/// @param sides what the images as a whole tell of them
/// @param coverage of find_boundary; changed in voxels whose neighbour across slices is labelled
/// otherwise
/// @return those, with what lies within
std::vector<Settled> cover_along_slices(const BoundaryInput& input, const Sides& sides,
                                        std::vector<float>& coverage);

}  // namespace beatlas::edges
