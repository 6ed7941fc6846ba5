#pragma once
/// The heart's shape as numbers.
/// Heart frame: z along the LV's long axis toward the base, x from the LV toward the RV, [mm];
/// the epicardial apex of the LV stays at z = apex_mm. Section 6 of the reference numbers.

#include <string>
#include <vector>

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

/// A sphere of blood that rides on a valve plane. What lies below the plane, or in a neighbour with
/// its wall (LV, then left atrium, then aorta), is not part of it.
struct Atrium {
  double radius_end_diastole_mm = 0;
  double radius_end_systole_mm = 0;
  double x_mm = 0;  ///< of its centre beside the axis of its ventricle
  double y_mm = 0;
};

struct Atria {
  bool present = true;
  Atrium left{22.0, 29.0, -6.0, -16.0};
  Atrium right{23.0, 29.0, 14.0, 0.0};
  double valve_radius_mm = 10.0;  ///< of the disc in which an atrium meets its valve plane
  double wall_mm = 2.0;
};

/// The root of the aorta: a cylinder on the LV's base plane.
struct AortaRoot {
  bool present = true;
  double radius_mm = 14.0;  ///< of the lumen
  double wall_mm = 2.0;
  double x_mm = 4.0;
  double y_mm = 22.0;
  double length_mm = 35.0;
};

/// Two ellipsoids along the LV's axis, in its cavity.
struct PapillaryMuscles {
  bool present = true;
  double radius_end_diastole_mm = 4.0;
  double radius_end_systole_mm = 6.0;
  double half_length_end_diastole_mm = 15.0;
  double half_length_end_systole_mm = 12.0;
  double off_axis = 0.6;  ///< of their centres, in radii of the cavity
};

/// Fat over the ventricles: none behind, `front_mm` in front.
struct PericardialFat {
  bool present = true;
  double front_mm = 6.0;
};

/// A segment of the LV wall that is thin and does not move: within a ball about a point of the end
/// diastolic wall the cavity always reaches `thinning_mm` beyond its end diastolic surface, the
/// epicardium `bulge_mm` beyond its own. The muscle beside the segment moves as ever, so the volume
/// of the muscle is not quite constant (truth.json has it for every phase).
struct Infarct {
  bool present = false;
  double radius_mm = 25.0;   ///< of the ball
  double angle_deg = 110.0;  ///< about the long axis, from the RV toward the front
  double z_mm = -34.0;       ///< heart frame
  double thinning_mm = 3.5;
  double bulge_mm = 0.5;
};

struct Anatomy {
  LvState lv_end_diastole{27.0, 62.0, 30.0, 6.0};
  LvState lv_end_systole{17.37, 51.22, 24.78, 8.0};
  double lv_wall_mm = 8.5;  ///< across, at end diastole; fixes the volume of the muscle
  double apex_mm = -68.0;
  RvState rv_end_diastole{28.0, -2.0, {32.5, 44.0, 62.0}, 32.0};
  RvState rv_end_systole{22.0, -8.0, {26.2, 36.0, 52.0}, 10.0};
  double rv_wall_mm = 3.5;

  Atria atria;
  AortaRoot aorta;
  PapillaryMuscles papillary_muscles;
  PericardialFat pericardial_fat;
  Infarct infarct;
  /// By how much the apex turns against the base until end systole, from the RV toward the front.
  /// The LV being round, only the papillary muscles show it; material.h tells where muscle goes.
  double torsion_deg = 0.0;

  Vec3 origin_lps_mm{14.0, 0.0, 8.0};           ///< where the heart frame's origin lies
  Vec3 apex_direction_lps{0.60, -0.55, -0.58};  ///< -z; normalised on use
  Vec3 rv_direction_lps{-0.80, -0.50, -0.30};   ///< x, made perpendicular to z on use
  double scale = 1.0;                           ///< of every length above but the origin
  double liver_rise_mm = 0.0;  ///< from where it lies clear of the heart; 20 brings them in touch
};

/// Rigid: heart frame [mm, scaled] -> patient LPS [mm].
[[nodiscard]] Affine lps_from_heart(const Anatomy& anatomy);

/// Leaves a body out: "atria", "aorta", "papillary_muscles", "pericardial_fat", or "all" of them.
/// @throws Error{Usage} listing the names if it is none of them.
void leave_out(Anatomy& anatomy, const std::string& body);
[[nodiscard]] std::vector<std::string> bodies_to_leave_out();
/// The two ventricles and nothing else.
[[nodiscard]] Anatomy ventricles_alone(Anatomy anatomy);

/// @throws Error{InvalidInput} naming the number that makes no heart.
void check_anatomy(const Anatomy& anatomy);

[[nodiscard]] nlohmann::json anatomy_to_json(const Anatomy& anatomy);
/// Strict; absent keys keep their default. @throws Error{InvalidInput} with the JSON path.
[[nodiscard]] Anatomy anatomy_from_json(const nlohmann::json& json, const std::string& path);

}  // namespace beatlas::phantom
