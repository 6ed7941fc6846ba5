#pragma once
/// Where in a stack the heart lies, so that the network need not run over all of every phase.

#include <vector>

#include "pipeline/prior/prior.h"
#include "pipeline/prior/slices.h"

namespace beatlas::prior {

/// [mm] Looked at beside the heart as it was seen in some phases. The base, which moves most, moves
/// by this much (phantom/family.json).
inline constexpr double kRoomMm = 25;

/// Phases that are looked at for it: three, so that one lies near end-diastole and one near
/// end-systole, wherever the beat begins; of three and fewer, all.
[[nodiscard]] std::vector<int> looked_at(int phases);

/// How much blood the LV holds at the least where it is largest [ml], of the body that has most: as
/// much as was seen in a phase, and as a ball as wide as its largest section, for a stack may show
/// a part of it alone and no LV is wider than long. 0 if no LV was seen.
[[nodiscard]] double least_lv_ml(const PriorCycle& looked);

/// The least box around what is likeliest to be heart in the phases that hold anything, with room
/// for what the others add. Of several bodies apart from each other those count that hold half as
/// much blood of the LV as the one with most: which one is the heart is told by who reads the
/// prior. All of the lattice if there is none.
/// @param multiple of width and height, as far as the lattice goes
[[nodiscard]] Window window_of_heart(const PriorCycle& looked, int multiple);

}  // namespace beatlas::prior
