#pragma once
/// Inside this room: slices of images and coverage as OpenCV sees them.

#include <array>
#include <vector>

#include <opencv2/core.hpp>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"

namespace beatlas::report {

/// The rectangle of the source's grid, in voxels, that holds the heart in these phases and a
/// margin; the whole slice if there is no heart.
[[nodiscard]] cv::Rect heart_rectangle(const Grid& source, const CoverageCycle& coverage,
                                       const std::vector<int>& phases, double margin_mm);

/// Slice k without copying; not to be written to.
[[nodiscard]] cv::Mat slice_view(const std::vector<float>& voxels, const Grid& grid, int k);

/// Grey window: the 1st and 99th percentile inside the rectangle over all slices of the phases.
[[nodiscard]] std::array<double, 2> grey_window(const Cine& cine, const std::vector<int>& phases,
                                                const cv::Rect& rectangle);

/// The coverage of one slice on the rectangle; zero outside the coverage's part of the grid.
[[nodiscard]] cv::Mat coverage_slice(const CoverageCycle& coverage,
                                     const std::vector<float>& voxels, int k,
                                     const cv::Rect& rectangle);

/// @throws Error{InvalidInput} if grids or phases disagree.
void check_fit(const Cine& cine, const Segmentation& segmentation);

}  // namespace beatlas::report
