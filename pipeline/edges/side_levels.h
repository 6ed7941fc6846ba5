#pragma once
/// What the two sides of a boundary look like, each by itself.

#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "pipeline/edges/boundary.h"

namespace beatlas::edges {

/// Share of a voxel inside a boundary below which something dark was taken in on purpose.
inline constexpr float kLeastInside = 0.2F;

/// What an image of one part of a slice holds of another; 0 where it holds nothing of it.
[[nodiscard]] cv::Mat framed(const cv::Mat& image, const cv::Rect& part, const cv::Rect& wanted);

/// Voxels of a mask whose neighbours, across slices as well, are of it too.
/// @param mask of each slice the part in `parts`; across slices what lies in none of them is not of
/// it
[[nodiscard]] std::vector<cv::Mat> whole_voxels(const std::vector<cv::Mat>& mask,
                                                const std::vector<cv::Rect>& parts);

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
  /// @param parts must stay within `input`'s slices; empty: of that slice nothing is asked
  LevelFinder(const BoundaryInput& input, const std::vector<cv::Rect>& parts);

  [[nodiscard]] SideLevels levels(int k) const;

 private:
  void put_bare(int k, const cv::Mat& in, SideLevels& levels, cv::Mat& inner_weight) const;

  const BoundaryInput& input_;
  const std::vector<cv::Rect>& parts_;
  cv::Size window_;
  std::vector<cv::Mat> pixels_;
  std::optional<WindowSums> inner_;  ///< of whole voxels; thin slices only
  std::optional<WindowSums> outer_;
};

/// How many pixels beyond the outlines levels come from.
[[nodiscard]] int level_reach_px(const Grid& grid);

}  // namespace beatlas::edges
