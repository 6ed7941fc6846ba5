#pragma once
/// Atria and the aorta as a prior names them: which of them can be believed.

#include <string>
#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::segment {

/// What is none of them, or in view in a part of the beat alone, becomes rest of the heart:
/// - one whose expected Dice (SliceBelief) is less than two thirds in some phase;
/// - an atrium that gives away three quarters of its volume (40 to 70 % are usual: Kawel-Boehm
///   2020, doi:10.1186/s12968-020-00683-3), or a structure that is elsewhere in the next phase;
/// - one that opens into the wrong ventricle: the left atrium and the aorta meet the LV, the right
///   atrium the RV.
/// @param belief of the labels, empty without a prior
/// @return a sentence each
std::vector<std::string> drop_doubtful_beyond_base(const Belief& belief,
                                                   ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
