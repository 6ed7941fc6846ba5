#pragma once
/// What no living heart is beyond, for all that judge one: the report, `validate`, and `build`.

namespace beatlas {

/// Ejection fraction of the LV [%]. No heart that ejects less keeps anyone alive, and none empties
/// itself: labels that do not follow the beat, or images that do not show one.
inline constexpr double kLeastEfPercent = 5;
inline constexpr double kMostEfPercent = 90;

}  // namespace beatlas
