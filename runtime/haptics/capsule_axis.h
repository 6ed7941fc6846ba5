#pragma once
/// What a capsule asks of a field: a sphere that is drawn along a straight axis touches where the
/// distance along that axis is least.

#include "runtime/haptics/contact_field.h"

namespace beatlas::haptics {

/// The axis from middle_mm - half_mm to middle_mm + half_mm; workspace [mm].
struct CapsuleAxis {
  Vec3 middle_mm = Vec3::Zero();
  Vec3 half_mm = Vec3::Zero();  ///< zero: a point

  /// @param share -1..1
  [[nodiscard]] Vec3 at(double share) const noexcept { return middle_mm + share * half_mm; }
};

struct NearestOnAxis {
  FieldSample sample;  ///< as of the capsule: how it changes as the whole axis moves
  double share = 0;    ///< where on the axis, -1..1
};

/// The least distance along the axis at a time. No stretch of it longer than the field's resolution
/// is passed over unless the distance at its ends says that it cannot be nearest (a gradient is
/// at most `steepest` long).
[[nodiscard]] NearestOnAxis nearest_on_axis(const ContactField& field, const CapsuleAxis& axis,
                                            double t, double steepest) noexcept;

/// Where along the axis (-1..1) the force of a bed of springs acts that the capsule presses in by
/// depth_mm at its nearest place: the mean of the shares, weighted by how deep each is.
/// @param axis of the capsule while it just touches; its radius [mm]
[[nodiscard]] double pressed_share(const ContactField& field, const CapsuleAxis& axis,
                                   double radius_mm, double depth_mm, double t) noexcept;

}  // namespace beatlas::haptics
