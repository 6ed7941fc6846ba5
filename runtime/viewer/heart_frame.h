#pragma once
/// The heart's own axes, standard views and planes through it.

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/atlas/atlas.h"
#include "runtime/base/geometry.h"

namespace beatlas::viewer {

/// Where the heart lies, at end-diastole; workspace frame.
struct HeartFrame {
  Vec3 centre_mm = Vec3::Zero();  ///< of the left ventricle's cavity, or of the heart
  Vec3 apexward = Vec3::UnitX();  ///< the long axis
  Vec3 to_right = Vec3::UnitY();  ///< perpendicular to it, towards the right ventricle
  Vec3 low_mm = Vec3::Zero();     ///< box of all surfaces through the cycle
  Vec3 high_mm = Vec3::Zero();
  Affine workspace_from_lps = Affine::Identity();

  [[nodiscard]] Vec3 lps(double l, double p, double s) const {
    return workspace_from_lps.linear() * Vec3(l, p, s);
  }
};

/// The long axis is the longest of the left ventricle's cavity (of the heart without it), the
/// apex's end the one that lies to the left, in front and below. Without a right ventricle its side
/// is the patient's right, in front. @throws Error{InvalidInput} if the atlas has no surface.
[[nodiscard]] HeartFrame heart_frame(const atlas::Atlas& atlas);

/// From the heart's middle to the left ventricle's free wall; not of unit length.
[[nodiscard]] Vec3 free_wall_direction(const HeartFrame& frame, const Vec3& heart_centre_mm);

/// Parallel projection.
struct CameraPose {
  Vec3 focus_mm = Vec3::Zero();
  Vec3 towards_viewer = Vec3::UnitZ();  ///< unit
  Vec3 up = Vec3::UnitY();              ///< unit
  double height_mm = 200;               ///< of the picture

  /// The picture's right, unit.
  [[nodiscard]] Vec3 right() const { return up.cross(towards_viewer).normalized(); }
};

/// anterior, left, right, posterior, superior, inferior: of a patient who stands; short-axis and
/// apex: from the apex, the right ventricle on the left; four-chamber: apex up, the right ventricle
/// on the left.
inline constexpr std::array<std::string_view, 9> kViews{"anterior",   "left",     "right",
                                                        "posterior",  "superior", "inferior",
                                                        "short-axis", "apex",     "four-chamber"};

/// @pre name is one of kViews
[[nodiscard]] CameraPose standard_view(const HeartFrame& frame, std::string_view name);

/// What lies on the normal's side is taken away.
struct CutPlane {
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< unit
};

inline constexpr std::array<std::string_view, 6> kCuts{"axial",      "coronal",      "sagittal",
                                                       "short-axis", "four-chamber", "two-chamber"};

/// Through the centre, moved by `offset_mm` along the normal: axial takes what is below, coronal
/// what is in front, sagittal what is on the patient's left, short-axis the apex's half,
/// four-chamber and two-chamber the half towards their viewer. @pre name is one of kCuts
[[nodiscard]] CutPlane standard_cut(const HeartFrame& frame, std::string_view name,
                                    double offset_mm);

}  // namespace beatlas::viewer
