#pragma once
/// Outlines of phases that are known teach those of the others: what draws outlines too far in or
/// out in one phase does so in the next.

#include <vector>

#include <opencv2/core.hpp>

namespace beatlas::segment {

/// Moves the outlines of one slice in every phase by as much as those that were grown in the known
/// phases lie off the given ones there, each place by the mean of what lies near it, each phase by
/// its two known neighbours in the cycle, the nearer the more.
/// @param outlines [phase] signed distance [mm] as grown, CV_32F, negative inside; changed in place
/// @param phases that are known, ascending; @param given [known] signed distance as given
/// @param pixel_mm mean edge of a pixel
void follow_known_outlines(std::vector<cv::Mat>& outlines, const std::vector<int>& phases,
                           const std::vector<cv::Mat>& given, double pixel_mm);

}  // namespace beatlas::segment
