#pragma once
/// Points of the LV's muscle that stay the same muscle through the cycle: for judging motion along
/// a surface, which no distance tells.

#include "pipeline/phantom/anatomy.h"

namespace beatlas::phantom {

/// Kept through the cycle. Shells between endocardium and epicardium are ellipsoids of revolution
/// about the long axis, cut by the base plane, that share the cavity's centre.
struct MaterialPoint {
  double height = 0;     ///< 0..1: of its shell, from its apex to the base plane
  double angle_rad = 0;  ///< about the long axis, from the RV, before torsion
  double mural = 0;      ///< 0..1: share of the muscle's volume between endocardium and its shell
};

/// Where it is; heart frame [mm], scaled. Torsion turns it about the long axis by
/// (1 - height) s torsion_deg: the apex leads, the base stays.
/// @param s share of the stroke volume that has left, 0..1
[[nodiscard]] Vec3 position_mm(const Anatomy& anatomy, const MaterialPoint& point, double s);

/// The point of the shell `mural` at the height and angle of a place near it: position_mm of it is
/// the place again where the place lies on that shell.
/// @param heart_mm heart frame [mm], scaled
[[nodiscard]] MaterialPoint material_at(const Anatomy& anatomy, const Vec3& heart_mm, double mural,
                                        double s);

}  // namespace beatlas::phantom
