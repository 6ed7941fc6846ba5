#pragma once
#include <vector>

namespace beatlas::alarm {

/// Phases that follow one another in the cycle whose volume leaves what those beside them foretell.
struct VolumeJump {
  int first = 0;      ///< phase
  int count = 1;      ///< of phases, cyclic
  int worst = 0;      ///< phase
  double beyond = 0;  ///< share of the curve's largest value by which `worst` is beyond; < 0: below
};

/// What is foretold of a run of phases lies between the volumes before and after it, or beyond both
/// as far as either's straight continuation into the run goes (fewer than 10 phases: as far as any
/// of them goes). A heart's own curve stays within that to 1 % from 12 phases on (3 % with 10),
/// however steep ejection and filling are, found on the phantom's at many trigger delays; a phase
/// that leaked does not. Runs of up to an eighth of the cycle, the worst first, each with the
/// former ones taken back to what was foretold.
/// @param limit share of the largest value; @return none for fewer than 5 phases, for then there
/// are no two independent phases on either side
[[nodiscard]] std::vector<VolumeJump> volume_jumps(const std::vector<double>& curve, double limit);

/// By how much of its largest value the curve steps from the last phase to the first, beyond the
/// steps before and after (0 for fewer than 10 phases: filling may then be one step). A leak that
/// grows from phase to phase shows here.
[[nodiscard]] double closing_step(const std::vector<double>& curve);

}  // namespace beatlas::alarm
