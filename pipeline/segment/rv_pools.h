#pragma once
/// The right ventricle's blood in thick slices, where fat and effusion on its thin wall are as
/// bright as it is and blur into it.

#include <vector>

#include "pipeline/segment/lv_chain.h"

namespace beatlas::segment {

inline constexpr double kBaseDescendsMm = 20;  ///< slices nearer to the base show atria in systole

/// A thin wall between two bright tissues is a dip, not dark: bright voxels are parted by dips, and
/// the RV is the part that leans on the LV's ring. It is followed from the slice that shows it
/// best: toward the apex a ventricle narrows, so that no slice holds it outside of the one before,
/// and toward the base it goes on as one pool.
/// @return [slice of the grid] 8-bit mask at end-diastole; empty where there is none
[[nodiscard]] std::vector<cv::Mat> rv_at_end_diastole(const Setting& s, const Chambers& chambers);

/// The same pool in every other phase: what is bright, parted by dips, and goes on from the phase
/// before, for a wall moves little from phase to phase and never beyond where diastole left it.
/// @param chambers with its RV at end-diastole
/// @return [phase][slice of the grid] 8-bit mask; empty where there is none
[[nodiscard]] std::vector<std::vector<cv::Mat>> rv_through_the_beat(const ImageCycle<float>& images,
                                                                    const Chambers& chambers);

}  // namespace beatlas::segment
