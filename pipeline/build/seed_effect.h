#pragma once
/// What a correction changed beside what it is for.

#include <vector>

#include "pipeline/core/leak_alarm.h"
#include "pipeline/core/shapes.h"

namespace beatlas::build {

/// The largest change of a label's volume in a phase [ml], of all labels and phases, where labels
/// changed and do not hang together, through space and time, with what changed in a ball of the
/// seeds. Labels that only change places there do not count: an outline that is looked for again
/// differs by a voxel here and there.
/// @pre both have one grid and the same phases
[[nodiscard]] double changed_elsewhere_ml(const LabelCycle& before, const LabelCycle& after,
                                          const std::vector<LeakSeed>& seeds);

}  // namespace beatlas::build
