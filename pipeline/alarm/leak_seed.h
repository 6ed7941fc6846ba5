#pragma once
/// The seed that pushes a leak back, as far as labels tell where what leaked lies.

#include <optional>
#include <vector>

#include "pipeline/core/leak_alarm.h"
#include "pipeline/core/shapes.h"

namespace beatlas::alarm {

/// Of an alarm on a patch of the heart's surface, under one place on it [mm, LPS]: background, in
/// the middle of what lies there beyond the thickness of a wall; right under the surface where that
/// is as dark as lung, or where what lies there does not end, as in a heart without chambers. In
/// every phase, where the place is never blood, and never the LV's muscle but in such a leak. None
/// where no more than a wall lies there: the surface may be right and only not be seen, and a seed
/// would eat into the wall. Place and radius are in tenths of a millimetre.
[[nodiscard]] std::optional<LeakSeed> seed_under(const LeakAlarm& alarm, const Vec3& lps_mm,
                                                 const LabelCycle& labels);

/// Of a volume that jumps: what the phases `before` and `after` agree on at the alarm's place. None
/// where they do not, or where the phase itself says the same.
[[nodiscard]] std::optional<LeakSeed> seed_beside(const LeakAlarm& alarm, const LabelCycle& labels,
                                                  int before, int after);

}  // namespace beatlas::alarm
