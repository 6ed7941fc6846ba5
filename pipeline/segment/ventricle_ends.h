#pragma once
/// Apex and base planes of a segmentation, in every phase, for the stages that follow.

#include <optional>
#include <string>
#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::segment {

/// The axis with its planes: through the middle of the LV's blood and wall at end-diastole, the way
/// that core's lv_direction tells. Base planes are those of the valves between thick
/// slices, see ValvePlane, as far as slices lie across enough for a plane between two of them to
/// have a height, else where a ventricle's section falls by half. The apex is where the
/// LV's outside, blood and wall, closes: near a rounded end the root of the volume below a height
/// grows nearly as the height, so it is carried on to nothing; where thick slices end before it,
/// shape/apical_end.h tells. None without LV blood and LV muscle, or if they have no length.
[[nodiscard]] std::optional<LongAxis> ventricle_axis(const Segmentation& segmentation);

/// Sentences on ends of the LV that lie beyond the images at end-diastole: its base, if muscle
/// still closes the cavity all round in the last slice there, its apex, if the sections as they
/// shrink would close more than a slice beyond the last one.
/// @param base_step +1 if the base lies towards larger k, -1 if smaller
/// @pre slices cut the LV across
[[nodiscard]] std::vector<std::string> cut_ends(const Segmentation& segmentation, int base_step);

/// Sets the planes of those phases whose labels were changed, from the labels as they are now;
/// axis and other phases stay. @param changed [phase] not 0: changed
void follow_changed_labels(Segmentation& segmentation, const std::vector<char>& changed);

}  // namespace beatlas::segment
