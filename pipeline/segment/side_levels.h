#pragma once
/// What the two sides of a boundary look like, each by itself.

#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "pipeline/segment/boundary.h"

namespace beatlas::segment {

/// Voxels of a mask, a slice each, whose neighbours, across slices as well, are of it too.
[[nodiscard]] std::vector<cv::Mat> whole_voxels(const std::vector<cv::Mat>& mask);

/// Empties slices of `mask` that are farther than `reach` slices from any of `inside`: no level is
/// asked for there.
void leave_far_slices(const std::vector<cv::Mat>& inside, int reach, std::vector<cv::Mat>& mask);

/// Sums over a window around each pixel of each slice.
struct WindowSums {
  std::vector<cv::Mat> pixels;  ///< of those of the mask
  std::vector<cv::Mat> weight;  ///< how many they are, as a share of the window

  WindowSums(const std::vector<cv::Mat>& image, const std::vector<cv::Mat>& mask,
             const cv::Size& window);
};

/// Share of a window, or of several slices' together, that has to tell a level.
inline constexpr float kLeastCore = 0.03F;

/// Levels of both sides around each pixel of a slice.
struct SideLevels {
  cv::Mat inner;
  cv::Mat outer;
  cv::Mat told;  ///< not 0 where these differ by more than the input's contrast
};

/// Finds them for a part of every slice.
class LevelFinder {
 public:
  /// @param part must stay within `input`'s slices
  LevelFinder(const BoundaryInput& input, const cv::Rect& part);

  [[nodiscard]] SideLevels levels(int k) const;

 private:
  void put_bare(int k, const cv::Mat& in, SideLevels& levels, cv::Mat& inner_weight) const;

  const BoundaryInput& input_;
  cv::Rect part_;
  cv::Size window_;
  std::vector<cv::Mat> pixels_;
  std::optional<WindowSums> inner_;  ///< of whole voxels; thin slices only
  std::optional<WindowSums> outer_;
};

/// How many pixels beyond the outlines levels come from.
[[nodiscard]] int level_reach_px(const Grid& grid);

}  // namespace beatlas::segment
