#pragma once
/// Which pools beside the ventricles' bases are of the heart: atria and the ascending aorta, not
/// the descending one.

#include "pipeline/segment/chambers.h"

namespace beatlas::segment {

/// Of thick slices. A vessel or an atrium that lies in its slice's zone for the most part lies in
/// it as a whole; beside the LV's most basal slice, which they may share with it, if it does so in
/// the next one. What runs past the heart from slice to slice, the descending aorta, lies in none.
/// @param chambers with an LV
/// @param zones [slice of the grid] 8-bit masks of where the heart may be; changed
void take_pools_whole(const Grid& grid, const Chambers& chambers, std::vector<cv::Mat>& zones);

}  // namespace beatlas::segment
