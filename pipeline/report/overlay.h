#pragma once
#include <cstddef>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"

namespace beatlas::report {

struct OverlayOptions {
  double margin_mm = 15;  ///< [mm] 0..200: room around the heart in the picture
  int tile_px = 280;      ///< 64..1024: longer edge of one slice's tile
};

/// A PNG sheet for a technician's eye: every slice of the stack at end-diastole and, beside it, at
/// end-systole, cropped to the heart and enlarged to square pixels, with the contour (coverage
/// 0.5) of each structure. The same input gives the same bytes.
/// @pre segmentation.coverage lies on a part of cine's grid, phase by phase.
/// @throws Error{InvalidInput} if grids or phases disagree.
[[nodiscard]] std::vector<std::byte> overlay_png(const Cine& cine, const Segmentation& segmentation,
                                                 const OverlayOptions& options = {});

/// A PNG of where a leak alarm rang: the slice at its place in its phase, with the contours and
/// without, both with a ring around the place, under a line that names alarm, figure and limit.
/// @throws Error{InvalidInput} if grids or phases disagree or the place lies outside the images.
[[nodiscard]] std::vector<std::byte> leak_png(const Cine& cine, const Segmentation& segmentation,
                                              const LeakAlarm& alarm,
                                              const OverlayOptions& options = {15, 560});

}  // namespace beatlas::report
