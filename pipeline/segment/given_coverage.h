#pragma once
/// Coverage that came from elsewhere beside labels of every phase.

#include <map>

#include "pipeline/core/shapes.h"

namespace beatlas::segment {

/// Share 0..1 of every voxel of a part of the exam's grid in a structure; 0 beyond that part.
struct PartCoverage {
  Index3 first{0, 0, 0};  ///< of the part in the exam's grid
  ImageCycle<float> share;
};
using GivenCoverage = std::map<Structure, PartCoverage>;

/// Images of shares as a part of an exam's grid, whose voxels they must be, in whatever order.
/// @throws Error{InvalidInput} if they lie between its voxels or beyond it.
[[nodiscard]] PartCoverage on_voxels_of(const ImageCycle<float>& images, Structure structure,
                                        const Grid& grid);

/// Puts given coverage in place of what was made of the labels; structures without keep that.
/// @param segmentation whose coverage holds all that is given
/// @throws Error{InvalidInput} where coverage and labels are of different segmentations: a
/// structure that the labels do not hold, another number of phases, or more than a few voxels that
/// one has wholly inside and the other outside.
void take_given_coverage(const GivenCoverage& given, Segmentation& segmentation);

}  // namespace beatlas::segment
