#pragma once
/// The part of the stack around the heart, of which a package's volume is made.

#include "pipeline/core/grid.h"
#include "pipeline/core/shapes.h"
#include "pipeline/pack/pack.h"

namespace beatlas::build {

/// A box of voxels of the stack.
struct StackBox {
  Index3 first{0, 0, 0};
  Index3 size{0, 0, 0};

  [[nodiscard]] bool holds(const StackBox& other) const;
};

/// The voxels around a lattice of the workspace and `margin_mm` beyond it, as far as the stack
/// reaches; of no size if it does not reach there at all.
[[nodiscard]] StackBox box_around(const Grid& lps_stack, const Affine& workspace_from_lps,
                                  const Grid& lattice, double margin_mm);

/// Images of a box of the stack; the grid is LPS.
struct HeartImages {
  StackBox box;
  ImageCycle<float> images;
  double noise = 0;  ///< of the whole stack: around the heart alone, motion would pass for noise
};

/// The noise is that of `from`. @param stack the grid of the whole stack: a part of a part of it
/// would lie elsewhere by a rounding @pre `from` holds the box
[[nodiscard]] HeartImages cut_images(const HeartImages& from, const Grid& stack,
                                     const StackBox& box);
/// @param stack the whole of it
/// @param noise see HeartImages
[[nodiscard]] HeartImages cut_images(const ImageCycle<float>& stack, double noise,
                                     const StackBox& box);

/// The volume of a package. @throws as pack::pack_volume
[[nodiscard]] pack::PackedVolume packed_volume(HeartImages around, const Affine& workspace_from_lps,
                                               const FieldCycle& heart,
                                               const pack::EncodeOptions& options);

}  // namespace beatlas::build
