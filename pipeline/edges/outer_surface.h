#pragma once
/// The heart's outside in space, from all that images show across it.

#include <cstdint>
#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/edges/fat_layer.h"
#include "pipeline/edges/layer_fit.h"

namespace beatlas::edges {

/// Pieces of the outside (surfels.h) are moved to where blood, muscle, fat and what lies beyond
/// (tissue_layers.h) explain best what voxels across them hold, whichever way the surface looks:
/// beside the slices, along them, and where blood comes to the surface at a base without a wall. A
/// film of fat of a quarter of a millimetre before lung looks like a millimetre more of muscle; no
/// place shows which it is, so that neighbours tell the layer's thickness together. Pieces that
/// four tissues do not explain, as where bodies meet, stay where labels put them. Phases that
/// `stay` do not change.
/// @param images, labels the heart's box, slices thinner than kThickSlicesMm; labels are changed to
/// what the surface says
/// @param levels fat's among them
/// @return [phase] voxels beside the surface, ascending
[[nodiscard]] std::vector<std::vector<FatEdge>> fit_outer_surface(
    const ImageCycle<float>& images, const LayerLevels& levels,
    const std::vector<std::uint8_t>& stay, ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::edges
