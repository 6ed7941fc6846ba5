#pragma once
/// Which way a left ventricle lies.

#include <optional>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas {

/// Unit vector [mm of the grid] along which the LV lies, from apex to base: the direction that the
/// wall of its cavity faces least. A cavity within muscle is a tube that is closed at the apex; its
/// wall stands across its axis however short or wide it is, and wherever slices begin and end. (The
/// longest axis of the ventricle with its wall, which is hardly longer than it is wide, lay 30 to
/// 90 degrees beside that on real exams.) The base is where no muscle bounds the cavity: all faces
/// of a closed body add up to nothing, so those of the opening are what those with muscle lack.
/// @param blood, muscle [voxel] 0..1: how much of it is the LV's blood, its muscle
/// @return none if the two do not touch; of a cavity that muscle closes all around either end may
/// come out as the base
[[nodiscard]] std::optional<Vec3> lv_direction(const Grid& grid, const std::vector<float>& blood,
                                               const std::vector<float>& muscle);

/// Whether slices of the grid cut what lies along `direction` across rather than along.
[[nodiscard]] bool cuts_across(const Grid& grid, const Vec3& direction);

}  // namespace beatlas
