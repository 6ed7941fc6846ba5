#pragma once
/// Coverage from labels, and labels from coverage.

#include <vector>

#include "pipeline/core/box.h"
#include "pipeline/core/shapes.h"
#include "pipeline/edges/fat_layer.h"
#include "pipeline/tissue/levels.h"
#include "pipeline/tissue/tissue.h"

namespace beatlas::edges {

/// Whether RV or rest of heart lies within 4 mm of a voxel, where labels of walls that meet are
/// mixed.
[[nodiscard]] bool beside_others(const Grid& grid, const std::vector<std::uint8_t>& labels,
                                 std::size_t voxel);

/// Coverage of every structure by the images' own edges and how well those are known, see
/// boundary.h; structures that no phase holds are left out.
struct Covered {
  CoverageCycle coverage;
  BoundaryUncertainty uncertainty;
};

/// @param images, labels the part of the exam in `box`; @param noise its standard deviation
/// @param under_fat [phase] or empty: voxels of the heart's edge that are known already
[[nodiscard]] Covered cover(const ImageCycle<float>& images, const ImageCycle<std::uint8_t>& labels,
                            const Box& box, const tissue::TissueLevels& levels, double noise,
                            const std::vector<std::vector<FatEdge>>& under_fat = {},
                            const std::vector<Structure>& structures = {kVentricular.begin(),
                                                                        kVentricular.end()});

/// Puts labels where coverage says: a voxel that a structure covers by half and more is of that
/// which covers most of it; one that lost its own is wall if it was a ventricle's blood and the
/// heart still covers it, and none of the heart if that does not. Labels without coverage of their
/// own stay where the heart does.
/// @param covered of these labels, on their grid
void follow_coverage(const CoverageCycle& covered, ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::edges
