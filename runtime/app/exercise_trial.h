#pragma once
/// One trial of an exercise, played once more from what was kept of it.

#include <vector>

#include "runtime/app/exercise_ground.h"
#include "runtime/app/trace.h"
#include "runtime/exercise/findings.h"

namespace beatlas::app {

struct TrialReplay {
  exercise::Findings findings;
  std::size_t ticks = 0;
  std::size_t different = 0;  ///< of them: the force did not come out the same to the bit
};

/// What a trainee did and felt in a trial: its ticks, each part from a heart that begins anew.
/// @param parts rows of each session that the trial was played in: a device that is lost ends one
/// @param heart_rate_per_min 0: the atlas's own
[[nodiscard]] TrialReplay replay_trial(const ExerciseGround& atlas, const exercise::Exercise& asked,
                                       const std::vector<exercise::Lesion>& lesions,
                                       const std::vector<std::vector<TraceRow>>& parts,
                                       double heart_rate_per_min);

}  // namespace beatlas::app
