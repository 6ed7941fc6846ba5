#pragma once
/// The heart's shape as numbers, and as primitives at one moment.
/// Heart frame: z along the LV's long axis toward the base, x from the LV toward the RV, [mm];
/// the epicardial apex of the LV stays at z = apex_mm. Section 6 of the reference numbers.

#include <nlohmann/json.hpp>

#include "pipeline/phantom/quadric.h"

namespace beatlas::phantom {

/// The LV cavity: an ellipsoid of revolution on the z axis, cut flat at the base.
struct LvState {
  double radius_mm = 0;     ///< semi-axis across
  double length_mm = 0;     ///< semi-axis along z
  double base_mm = 0;       ///< base plane above the ellipsoid's centre
  double apex_wall_mm = 0;  ///< wall at the apex
};

/// The RV cavity: an ellipsoid below z = cut_mm, without what lies in the LV's epicardial
/// ellipsoid (the whole of it, beyond the base plane too). centre y = 0.
struct RvState {
  double centre_x_mm = 0;
  double centre_z_mm = 0;
  Vec3 semi_axes_mm = Vec3::Ones();
  double cut_mm = 0;
};

struct Anatomy {
  LvState lv_end_diastole{27.0, 62.0, 30.0, 6.0};
  LvState lv_end_systole{17.37, 51.22, 24.78, 8.0};
  double lv_wall_mm = 8.5;  ///< across, at end diastole; fixes the volume of the muscle
  double apex_mm = -68.0;
  RvState rv_end_diastole{28.0, -2.0, {32.5, 44.0, 62.0}, 32.0};
  RvState rv_end_systole{22.0, -8.0, {26.2, 36.0, 52.0}, 10.0};
  double rv_wall_mm = 3.5;

  Vec3 origin_lps_mm{0.0, 0.0, 8.0};            ///< where the heart frame's origin lies
  Vec3 apex_direction_lps{0.60, -0.55, -0.58};  ///< -z; normalised on use
  Vec3 rv_direction_lps{-0.80, -0.50, -0.30};   ///< x, made perpendicular to z on use
  double scale = 1.0;                           ///< of every length above but the origin
};

/// Rigid: heart frame [mm, scaled] -> patient LPS [mm].
[[nodiscard]] Affine lps_from_heart(const Anatomy& anatomy);

/// The primitives at one value of s (see motion.h), scaled.
struct HeartShape {
  Ellipsoid lv_cavity;
  Ellipsoid lv_epicardium;
  double lv_base_z_mm = 0;
  Ellipsoid rv_cavity;
  Ellipsoid rv_outer;
  double rv_cut_z_mm = 0;
};

/// The LV wall across follows from the muscle's volume at end diastole:
///   V = pi A^2 (b - b^3 / (3 C^2) + 2 C / 3)  for semi-axes A, A, C cut b above the centre.
/// @param s share of the stroke volume that has left, 0..1
[[nodiscard]] HeartShape heart_shape(const Anatomy& anatomy, double s);

/// Volume [ml] of an ellipsoid below the plane z = cut_z_mm.
[[nodiscard]] double cut_ellipsoid_ml(const Ellipsoid& ellipsoid, double cut_z_mm);

/// Volume [ml] common to two ellipsoids with centres at the same y, below z = cut_z_mm: the areas
/// common to their sections in closed form, integrated along z to 1e-6 ml.
[[nodiscard]] double common_ml(const Ellipsoid& a, const Ellipsoid& b, double cut_z_mm);

/// @throws Error{InvalidInput} naming the number that makes no heart.
void check_anatomy(const Anatomy& anatomy);

[[nodiscard]] nlohmann::json anatomy_to_json(const Anatomy& anatomy);
/// Strict; absent keys keep their default. @throws Error{InvalidInput} with the JSON path.
[[nodiscard]] Anatomy anatomy_from_json(const nlohmann::json& json, const std::string& path);

}  // namespace beatlas::phantom
