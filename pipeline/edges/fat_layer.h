#pragma once
/// Fat on the outside of the heart, where it is too thin for voxels of its own.

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/edges/layer_fit.h"
#include "pipeline/tissue/levels.h"

namespace beatlas::edges {

/// What is known of the heart's edge under fat.
struct FatEdge {
  static constexpr std::uint32_t kNowhere = 0xFFFFFFFF;

  std::uint32_t voxel = 0;
  std::uint32_t within =
      kNowhere;        ///< the heart's voxel that lies inward of it, where that is known
  float coverage = 0;  ///< of the heart
  float sigma_mm = 0;  ///< of the edge
};

/// Levels of the tissues, where the images show fat around the heart: brighter than blood, or
/// brighter than muscle where contrast is low.
/// @param images, labels the heart's box  @param noise standard deviation
[[nodiscard]] std::optional<LayerLevels> levels_with_fat(const ImageCycle<float>& images,
                                                         double noise,
                                                         const tissue::TissueLevels& levels,
                                                         const ImageCycle<std::uint8_t>& labels);

/// In each slice profiles across the heart's outline, means along it, are fitted with muscle, fat
/// and what lies beyond (layer_fit.h); where there is a layer of fat it comes off the labels. Three
/// tissues within two voxels are more than a boundary between two levels can tell of, so that
/// voxels there get their coverage here. Nothing changes where no muscle is seen between blood and
/// the outline, and in phases that `stay`. For slices that stand alone; see outer_surface.h for
/// thin ones.
/// @param stay [phase] not 0: its labels are known
/// @return [phase] voxels within 3 pixels of an edge under fat, ascending
[[nodiscard]] std::vector<std::vector<FatEdge>> strip_fat_layer(
    const ImageCycle<float>& images, const LayerLevels& levels,
    const std::vector<std::uint8_t>& stay, ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::edges
