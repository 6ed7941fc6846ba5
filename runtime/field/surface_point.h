#pragma once
#include "runtime/field/field_query.h"

namespace beatlas::field {

/// Outermost point of the surface on the ray from the structure's centre along `direction` at time
/// t; workspace [mm]. @throws Error{InvalidInput} if the ray meets no surface.
[[nodiscard]] Vec3 surface_point_mm(const FieldQuery& field, const Vec3& direction, double t);

}  // namespace beatlas::field
