#pragma once
/// The leak alarm: does a segmentation look as if a label had run where it does not belong? Asked
/// of labels, coverage and images alone, whoever made them.

#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/leak_alarm.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::segment {

/// What a leak alarm does.
enum class LeakAction { Warn, Error };

/// Limits: what clean segmentations of phantoms stay below; see tests/soak.
struct LeakOptions {
  LeakAction action = LeakAction::Warn;
  /// [%] 2..100: how far a phase's volume may leave what the phases beside it foretell, of the
  /// structure's largest.
  double volume_percent = 6;
  /// [mm2] 10..10000: patch of the heart's surface along the border of the slices, or with lung or
  /// air under it.
  double contact_mm2 = 200;
  /// [mm2] 10..10000: patch of the heart's surface along an edge that does not move. An apex hardly
  /// does.
  double still_mm2 = 1500;
  /// [mm2] 10..10000: patch of a structure's surface without an edge in the image.
  double edgeless_mm2 = 200;
};

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

}  // namespace beatlas::segment
