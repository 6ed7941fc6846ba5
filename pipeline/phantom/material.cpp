#include "pipeline/phantom/material.h"

#include <algorithm>
#include <cmath>

#include "pipeline/phantom/heart_shape.h"

namespace beatlas::phantom {

Vec3 position_mm(const Anatomy& anatomy, const MaterialPoint& point, double s) {
  const Ellipsoid shell = lv_shell(anatomy, s, point.mural);
  const double low = shell.centre_mm.z() - shell.semi_axes_mm.z();
  const double base = heart_shape(anatomy, s).lv_base_z_mm;
  const double z = low + point.height * (base - low);
  const double u = (z - shell.centre_mm.z()) / shell.semi_axes_mm.z();
  const double radius = shell.semi_axes_mm.x() * std::sqrt(std::max(0.0, (1.0 - u) * (1.0 + u)));
  const double angle = point.angle_rad + torsion_rad(anatomy, s, point.height);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

MaterialPoint material_at(const Anatomy& anatomy, const Vec3& heart_mm, double mural, double s) {
  const Ellipsoid shell = lv_shell(anatomy, s, mural);
  const double low = shell.centre_mm.z() - shell.semi_axes_mm.z();
  const double base = heart_shape(anatomy, s).lv_base_z_mm;
  MaterialPoint out;
  out.height = std::clamp((heart_mm.z() - low) / (base - low), 0.0, 1.0);
  out.angle_rad = std::atan2(heart_mm.y(), heart_mm.x()) - torsion_rad(anatomy, s, out.height);
  out.mural = mural;
  return out;
}

}  // namespace beatlas::phantom
