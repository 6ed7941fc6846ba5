#pragma once
/// From the left ventricle's endocardium through its wall to where a finger can touch it.

#include <optional>

#include "runtime/field/field_query.h"
#include "runtime/palpation/lv_wall.h"

namespace beatlas::palpation {

/// The place of the heart's surface over a vertex at end-diastole, along the endocardium's normal
/// [mm]; none where more lies there than the wall and AtlasMuscle::kOutsideMm: another part of the
/// heart is touched there.
/// @param heart field of the heart  @param end_diastole_s time of it in the field's cycle
[[nodiscard]] std::optional<Vec3> over_wall(const LvWall& wall, std::uint32_t vertex,
                                            const field::FieldQuery& heart, double end_diastole_s);

}  // namespace beatlas::palpation
