#pragma once
/// Whether the labels do what a technician's seeds say, so that none is passed over in silence.

#include <string>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/segment/competition.h"
#include "pipeline/segment/options.h"

namespace beatlas::segment {

/// Seeds of the heart that the labels do not follow, a sentence each as seed_told begins it, with
/// phases and why: where at least half of what a seed marks (and no later one marks anew)
/// has another label, or where it stays alone: no more hangs together with it in its slices, in its
/// label, than it marks itself. At most five, and how many more.
/// @param grown labels as they grew
/// @param labels as they are once those that were given are put back, before atria are parted
/// @param marks what seeds drew on their grid, kUnlabelled elsewhere
[[nodiscard]] std::vector<std::string> seeds_not_followed(const ImageCycle<std::uint8_t>& grown,
                                                          const ImageCycle<std::uint8_t>& labels,
                                                          const std::vector<Seed>& seeds,
                                                          const LabelImages& marks);

}  // namespace beatlas::segment
