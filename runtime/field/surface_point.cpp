#include "runtime/field/surface_point.h"

#include <algorithm>

#include "runtime/base/error.h"

namespace beatlas::field {

Vec3 surface_point_mm(const FieldQuery& field, const Vec3& direction, double t) {
  const atlas::FieldPayload& payload = field.payload();
  const Vec3 extent_mm =
      payload.voxel_mm * atlas::FieldPayload::kBlockEdge *
      Vec3(payload.block_count[0], payload.block_count[1], payload.block_count[2]);
  const Vec3 unit = direction.normalized();
  const double step_mm = 0.25 * payload.voxel_mm;
  const auto distance_mm = [&](double along) {
    return field.sample(field.centre_mm() + along * unit, t).distance_mm;
  };
  double outside = extent_mm.norm();
  while (distance_mm(outside) > 0) {
    // The distance is a safe step where it is exact; its clamp and the spline are not above it.
    outside -= std::max(step_mm, 0.9 * distance_mm(outside));
    if (outside < -extent_mm.norm()) {
      throw_invalid("the field holds no surface on the chosen side; choose another side");
    }
  }
  double inside = outside;
  while (distance_mm(outside) <= 0) outside += step_mm;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (inside + outside);
    (distance_mm(middle) > 0 ? outside : inside) = middle;
  }
  return field.centre_mm() + outside * unit;
}

}  // namespace beatlas::field
