#pragma once
/// The leak alarm: does a segmentation look as if a label had run where it does not belong? Asked
/// of labels, coverage and images alone, whoever made them.

#include <vector>

#include "pipeline/alarm/options.h"
#include "pipeline/core/exam.h"
#include "pipeline/core/leak_alarm.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::alarm {

/// The alarms that ring, by kind, one for the worst phase of a structure and kind (of volume jumps
/// one for each).
///
/// - Volume: see volume_jumps.h; of every structure.
/// - Contact, of the heart: labels within two pixels of the slices' border; surface with the dark
/// of
///   lung 2 to 3 mm under it; surface along an edge whose place does not change through the cycle
///   (a leak that filled the liver or the chest wall to its own edge).
/// - No edge, of the heart and the blood pools: surface along which the levels on both sides differ
///   by less than an eighth of blood above muscle, as of muscle against a liver as bright. Where
///   both sides are blood nothing is said: through valves and great vessels a surface has no edge.
///   The LV's muscle has no surface of its own but towards muscle.
///
/// @pre cine and segmentation have one grid and the same phases.
[[nodiscard]] std::vector<LeakAlarm> leak_alarms(const Cine& cine, const Segmentation& segmentation,
                                                 const LeakOptions& options, StageContext& context);

/// @throws Error{Quality} with the first alarm's sentence, if there is one and `action` is Error.
void demand_no_leak(const std::vector<LeakAlarm>& alarms, LeakAction action);

}  // namespace beatlas::alarm
