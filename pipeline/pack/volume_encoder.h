#pragma once
#include "pipeline/core/shapes.h"
#include "pipeline/pack/pack.h"
#include "runtime/atlas/bytes.h"

namespace beatlas::pack {

/// Images -> volumes/heart.volume.zst (runtime/atlas/volume_payload.h), decoded again and compared.
///
/// A term of the transform is rounded to counts of options.volume_step times the noise. Those below
/// options.volume_threshold times the noise are 0: what the heart and its motion give stands out of
/// the noise in few terms, noise itself lies evenly in all (Donoho and Johnstone, "Ideal spatial
/// adaptation by wavelet shrinkage", Biometrika 81, 1994). So what comes back is nearer to the
/// heart than the images are. In blocks that no part of the heart comes near in any phase, step and
/// threshold are twice as large.
/// @param images cut to the heart (its grid: workspace [mm])
/// @param noise standard deviation in one phase, >= 0; less than a 2000th of the images' range
/// counts as that
/// @param heart tells which blocks come within its outer_mm
/// @throws Error{InvalidInput} if the images are empty, differ in size or hold what is no number;
/// Error{Usage} if step or threshold is out of range.
[[nodiscard]] PackedVolume pack_volume(const ImageCycle<float>& images, double noise,
                                       const FieldCycle& heart, const EncodeOptions& options);

}  // namespace beatlas::pack
