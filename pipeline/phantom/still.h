#pragma once
/// What of the images does not beat, slice by slice as each was shifted.

#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/phantom/acquisition.h"
#include "pipeline/phantom/coil_bias.h"
#include "pipeline/phantom/cover.h"

namespace beatlas::phantom {

/// One value a voxel; blood = 1. Empty where the scanner's switch is off.
struct StillImages {
  std::vector<float> behind;  ///< signal of the thorax without the heart
  std::vector<float> bias;    ///< sensitivity of the coil
  std::vector<float> arms;    ///< signal of the arms as it folds over, with the bias of its place
};

[[nodiscard]] StillImages still_images(const PhantomSpec& spec, const Signals& signals,
                                       const std::vector<SliceAcquisition>& slices,
                                       const CoverOptions& options);

/// The options of `cover` that stand for this scanner. A blur hides the curvature of pieces of 3
/// mm.
[[nodiscard]] CoverOptions cover_options(const ScannerSpec& scanner);

/// Voxels (i, j, k) of the block in order.
template <class F>
void for_each_voxel(const Block& block, const F& visit) {
  for (int k = block.first[2]; k < block.first[2] + block.size[2]; ++k) {
    for (int j = block.first[1]; j < block.first[1] + block.size[1]; ++j) {
      for (int i = block.first[0]; i < block.first[0] + block.size[0]; ++i) visit(i, j, k);
    }
  }
}

/// Tiles of single slices: what the images are made by.
[[nodiscard]] std::vector<Block> tiles_of(const Grid& grid);

}  // namespace beatlas::phantom
