#pragma once
/// Plain region growing: what a window of intensity holds and hangs together with a seed. The
/// method of paper A, kept for comparison; it leaks wherever blood touches what is as bright.

#include <cstdint>
#include <vector>

#include "pipeline/core/box.h"
#include "pipeline/core/exam.h"
#include "pipeline/segment/competition.h"
#include "pipeline/segment/options.h"
#include "pipeline/tissue/levels.h"

namespace beatlas::segment {

/// Ends included.
struct IntensityWindow {
  double low = 0;
  double high = 0;
  Neighbours neighbours = Neighbours::Faces;
};

/// 1 in voxels that a way of neighbours within the window joins to a seed within it.
[[nodiscard]] std::vector<std::uint8_t> grow_in_window(const Grid& grid,
                                                       const std::vector<float>& image,
                                                       const std::vector<std::size_t>& seeds,
                                                       const IntensityWindow& window);

/// LV blood of every phase, each grown alone through the whole of the images; the heart is what
/// grew, and coverage that of the labels' own smoothed outlines. A drawn seed of LV blood stands in
/// every phase, for paper A has its seeds in each; without any, `automatic` ones do.
/// @param stack the images, bad frames mended  @param automatic seeds of every label in `box`
/// @param levels what the window is made from where the options leave it open
/// @throws Error{InvalidInput} if there is no seed of LV blood, a window has no width, or nothing
/// grows in a phase.
[[nodiscard]] Segmentation segment_by_threshold(const ImageCycle<float>& stack,
                                                const std::vector<Seed>& drawn,
                                                const LabelImages& automatic, const Box& box,
                                                const tissue::TissueLevels& levels,
                                                const SegmentOptions& options);

}  // namespace beatlas::segment
