#pragma once
/// Automatic finding of the chambers: the left ventricle is the beating blood pool inside a ring
/// of muscle, the right one the pool that leans on that ring.

#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "pipeline/core/grid.h"
#include "pipeline/segment/long_axis.h"
#include "pipeline/segment/ring.h"
#include "pipeline/segment/tissue.h"

namespace beatlas::segment {

/// The left ventricle in one slice.
struct LvSlice {
  int k = 0;
  cv::Point2d centre_px;
  std::vector<Ring> rings;  ///< [phase]
};

struct Chambers {
  TissueLevels levels;
  std::vector<LvSlice> lv;  ///< neighbouring slices, ascending k; may be empty
  int base_step = 0;        ///< +1 if the base lies towards larger k, -1 if smaller
  int end_diastole = 0;     ///< phase of the largest blood area
  int end_systole = 0;
  double wall_mm = 0;                    ///< median wall at end-diastole
  std::vector<double> wall_by_phase_mm;  ///< [phase] median over slices; 0 where no LV was found
  std::vector<cv::Mat> rv;               ///< [slice of the grid] 8-bit mask of RV blood at ED
  std::vector<cv::Mat> always_blood;  ///< [slice] 8-bit mask: brighter than muscle in every phase
  std::vector<cv::Mat> always_blood_moving;  ///< [slice] those of its parts whose rim moves

  std::optional<LongAxis> axis;  ///< of thin slices, where it could be found
  std::vector<float> height_mm;  ///< [voxel] along it; empty without

  [[nodiscard]] bool parts_atria() const { return axis && axis->atria; }
  [[nodiscard]] bool found_lv() const { return !lv.empty(); }
};

/// @param images the heart's box; @param stats of the same grid
[[nodiscard]] Chambers find_chambers(const ImageCycle<float>& images, const TemporalStats& stats,
                                     StageContext& context);

/// Takes a technician's word for it: traces the LV's ring around `centre_px` of slice `k` in every
/// phase and adds the slice to the LV's, if it is not among them. Nothing without an LV found.
void adopt_lv_slice(Chambers& chambers, const ImageCycle<float>& images, int k,
                    const cv::Point2d& centre_px);

/// Structuring element of a disc, at least one pixel in radius.
[[nodiscard]] cv::Mat disc(double radius_mm, const cv::Point2d& pixel_mm);

/// The part of a slice that holds the mask, with `room_px` around it; empty if there is none.
[[nodiscard]] cv::Rect rect_around(const cv::Mat& mask, int room_px);

/// One slice of one phase as a matrix that shares the voxels.
[[nodiscard]] cv::Mat slice_of(const Grid& grid, const std::vector<float>& image, int k);
[[nodiscard]] cv::Mat slice_of(const Grid& grid, const std::vector<std::uint8_t>& image, int k);

}  // namespace beatlas::segment
