#pragma once
#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/field/simple_topology.h"

namespace beatlas::field {

/// Changes the samples of every phase so that their zero surface is one sphere, and the same one
/// all the cycle: where a loop of parts that touch (two atria and the aorta between them) is cut in
/// one phase and its hole filled in another, no mesh could go from one to the other without passing
/// through itself. A piece apart that is in the body in another phase, and lies in it through those
/// between, belongs to it: its neck is lost in some phases, and is put where the others have it.
/// One phase is made a ball, see make_ball; that body becomes the next phase's by points that leave
/// its topology as it is, surest first (homotopic deformation; Bertrand 1994, Han et al. 2003), and
/// so on in both directions. What cannot be reached is where a handle was closed, or a piece or a
/// hollow that the phase alone has. Of the phases of the fewest handles, or of 32 spread among them
/// where there are more, that one is the first of which least is changed; where both ways meet and
/// disagree counts once a phase. Deterministic, the same bits for any number of threads.
/// @param phases distances on `grid`, clamped or not; a cycle of balls stays as it is
/// @return what was done to each phase
std::vector<Repair> make_balls(const Grid& grid, std::vector<std::vector<float>>& phases,
                               const StageContext& context);

}  // namespace beatlas::field
