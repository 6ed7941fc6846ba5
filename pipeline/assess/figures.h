#pragma once
/// What a comparison with the truth finds, as numbers. One table a kind of figure gives each its
/// name in JSON and the limit that may bound it; the limits have one table of names too. To add a
/// figure, add its member and its line.

#include <array>
#include <map>
#include <optional>
#include <string_view>

#include "runtime/atlas/structures.h"
#include "runtime/base/geometry.h"

namespace beatlas::assess {

/// The limit of each figure; those not set do not count. A figure's magnitude counts.
struct Limits {
  std::optional<double> min_dice;
  std::optional<double> max_volume_error_ml;
  std::optional<double> max_volume_error_percent;
  std::optional<double> max_mean_mm;
  std::optional<double> max_rms_mm;
  std::optional<double> max_p95_mm;
  std::optional<double> max_hausdorff_mm;
  std::optional<double> max_bias_mm;
  std::optional<double> max_normal_mean_deg;
  std::optional<double> max_normal_p95_deg;
  std::optional<double> max_velocity_mean_mm_s;
  std::optional<double> max_velocity_p95_mm_s;
  std::optional<double> max_thickness_mean_mm;
  std::optional<double> max_thickness_p95_mm;
  std::optional<double> max_thickness_bias_mm;
  std::optional<double> max_motion_mean_mm;
  std::optional<double> max_motion_p95_mm;
  std::optional<double> max_motion_tangential_share;
  std::optional<double> max_map_thickness_mean_mm;
  std::optional<double> max_map_thickness_p95_mm;
  std::optional<double> min_map_segments_percent;
  std::optional<double> max_ejection_fraction_error;
  std::optional<double> max_force_mean_n;
  std::optional<double> max_force_rms_n;
  std::optional<double> max_force_p95_n;
  std::optional<double> max_force_n;
  std::optional<double> max_force_mean_jnd;
  std::optional<double> max_force_p95_jnd;
  std::optional<double> max_contact_differs_percent;
  std::optional<double> max_force_jump_n;
};

using LimitMember = std::optional<double> Limits::*;

/// The key of a recipe's section "validate"; the option is it with '-' for '_'.
struct LimitName {
  const char* name;
  LimitMember member;
  double most;       ///< of the range 0..most
  const char* help;  ///< what is bounded
  [[nodiscard]] constexpr bool is_least() const {
    return std::string_view(name).starts_with("min_");
  }
};

inline constexpr std::array kLimitNames{
    LimitName{"min_dice", &Limits::min_dice, 1, "Dice"},
    LimitName{"max_volume_error_ml", &Limits::max_volume_error_ml, 1e4, "Error of the volume"},
    LimitName{"max_volume_error_percent", &Limits::max_volume_error_percent, 1e4,
              "The same, of the true volume"},
    LimitName{"max_mean_mm", &Limits::max_mean_mm, 1e3, "Mean distance of the surfaces"},
    LimitName{"max_rms_mm", &Limits::max_rms_mm, 1e3, "Root mean square of the distance"},
    LimitName{"max_p95_mm", &Limits::max_p95_mm, 1e3, "95th percentile of the distance"},
    LimitName{"max_hausdorff_mm", &Limits::max_hausdorff_mm, 1e3, "Largest distance"},
    LimitName{"max_bias_mm", &Limits::max_bias_mm, 1e3, "Signed mean distance"},
    LimitName{"max_normal_mean_deg", &Limits::max_normal_mean_deg, 180, "Mean angle of normals"},
    LimitName{"max_normal_p95_deg", &Limits::max_normal_p95_deg, 180,
              "95th percentile of the angle"},
    LimitName{"max_velocity_mean_mm_s", &Limits::max_velocity_mean_mm_s, 1e5,
              "Mean error of the surface's velocity"},
    LimitName{"max_velocity_p95_mm_s", &Limits::max_velocity_p95_mm_s, 1e5, "Its 95th percentile"},
    LimitName{"max_thickness_mean_mm", &Limits::max_thickness_mean_mm, 1e3,
              "Mean error of the LV's wall thickness"},
    LimitName{"max_thickness_p95_mm", &Limits::max_thickness_p95_mm, 1e3, "Its 95th percentile"},
    LimitName{"max_thickness_bias_mm", &Limits::max_thickness_bias_mm, 1e3, "Its signed mean"},
    LimitName{"max_motion_mean_mm", &Limits::max_motion_mean_mm, 1e3,
              "Mean way of a surface's vertices off the LV's muscle they are on"},
    LimitName{"max_motion_p95_mm", &Limits::max_motion_p95_mm, 1e3, "Its 95th percentile"},
    LimitName{"max_motion_tangential_share", &Limits::max_motion_tangential_share, 1e3,
              "Its part along the surface, over that of motion along normals alone"},
    LimitName{"max_map_thickness_mean_mm", &Limits::max_map_thickness_mean_mm, 1e3,
              "Mean error of the thickness at the vertices of a surface on the LV's wall"},
    LimitName{"max_map_thickness_p95_mm", &Limits::max_map_thickness_p95_mm, 1e3,
              "Its 95th percentile"},
    LimitName{"min_map_segments_percent", &Limits::min_map_segments_percent, 100,
              "Vertices on the LV's wall in the right AHA segment"},
    LimitName{"max_ejection_fraction_error", &Limits::max_ejection_fraction_error, 1,
              "Error of the ejection fraction, a share"},
    LimitName{"max_force_mean_n", &Limits::max_force_mean_n, 1e3, "Mean error of the force"},
    LimitName{"max_force_rms_n", &Limits::max_force_rms_n, 1e3, "Its root mean square"},
    LimitName{"max_force_p95_n", &Limits::max_force_p95_n, 1e3, "Its 95th percentile"},
    LimitName{"max_force_n", &Limits::max_force_n, 1e3, "Its largest value"},
    LimitName{"max_force_mean_jnd", &Limits::max_force_mean_jnd, 1e5,
              "Mean error over what can just be noticed"},
    LimitName{"max_force_p95_jnd", &Limits::max_force_p95_jnd, 1e5, "Its 95th percentile"},
    LimitName{"max_contact_differs_percent", &Limits::max_contact_differs_percent, 100,
              "Ticks that are in contact in one of both only"},
    LimitName{"max_force_jump_n", &Limits::max_force_jump_n, 1e3,
              "Largest change of the force from tick to tick"},
};

/// Limits of all structures, and those that replace them for one.
struct LimitSet {
  Limits all;
  std::map<Structure, Limits> structures;

  [[nodiscard]] Limits of(Structure structure) const;
};

/// One structure in one phase.
struct PhaseErrors {
  double dice = 0;                  ///< 0..1, voxels of the source's grid by their centres
  double volume_error_ml = 0;       ///< the package's volume curve minus the truth
  double volume_error_percent = 0;  ///< the same, of the true volume
  // Distances between the surfaces, both ways: points of the package's zero level to the exact
  // truth, points of the true surface to the package's field; each way has half of the weight.
  double mean_mm = 0;
  double rms_mm = 0;
  double p95_mm = 0;
  double hausdorff_mm = 0;
  double bias_mm = 0;  ///< signed mean, + where the package is larger
  // At points of the true surface, what the package's field says there.
  double normal_mean_deg = 0;     ///< angle between the field's outward normal and the true one
  double normal_p95_deg = 0;      ///<
  double velocity_mean_mm_s = 0;  ///< magnitude of the difference of velocities along the normal
  double velocity_p95_mm_s = 0;   ///<
  int points = 0;                 ///< points of both ways
};

/// One structure in one phase by its surface alone; see drawn_errors.h. Limits bound those of the
/// ventricles and the heart.
struct DrawnErrors {
  double volume_error_ml = 0;       ///< the surface's volume minus the truth
  double volume_error_percent = 0;  ///< the same, of the true volume
  double mean_mm = 0;               ///< distances both ways, as of PhaseErrors
  double rms_mm = 0;
  double p95_mm = 0;
  double hausdorff_mm = 0;
  double bias_mm = 0;  ///< signed mean, + where the package is larger
  int points = 0;      ///< of both ways; 0: the truth has no such part
};

/// A vertex of a surface in one phase. Workspace [mm].
struct VertexError {
  Vec3 place = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< outward, of its triangles by their areas
  double area_mm2 = 0;         ///< a third of its triangles
  double off_mm = 0;           ///< from the true surface, + outside
};

/// Wall thickness of the LV in one phase: package minus truth along the same rays.
struct ThicknessErrors {
  double mean_mm = 0;       ///< of magnitudes
  double p95_mm = 0;        ///< of magnitudes
  double bias_mm = 0;       ///< signed mean, + where the package's wall is thicker
  double true_mean_mm = 0;  ///< the true thickness, mean over the rays
  int points = 0;           ///< rays measured in both
  int missing = 0;          ///< rays on which the package has no wall
};

/// How far the vertices of a surface leave the muscle of the LV that they are on, see
/// motion_error.h; over all phases but the first.
struct MotionErrors {
  double mean_mm = 0;
  double p95_mm = 0;
  double tangential_mean_mm = 0;  ///< of the part along the true surface
  double tangential_p95_mm = 0;
  double normal_only_mean_mm = 0;             ///< of points that move along normals alone
  double normal_only_tangential_mean_mm = 0;  ///<
  double tangential_share = 0;  ///< tangential_mean_mm over that of normal-only motion
  int points = 0;               ///< vertices on the LV's wall
};

/// The map of a surface on a ventricle's wall, see map_error.h; all phases together.
struct MapErrors {
  double thickness_mean_mm = 0;  ///< of magnitudes
  double thickness_p95_mm = 0;
  double thickness_bias_mm = 0;       ///< + where the map's wall is thicker
  double thickness_true_mean_mm = 0;  ///< the true thickness at the same places
  double segments_percent = 0;        ///< of `named`: in the right segment
  int points = 0;                     ///< thicknesses compared
  int missing = 0;                    ///< there is a wall, and the map has none, as the RV's may
  int named = 0;                      ///< vertices whose segment was asked for; none on the RV
};

/// What a hand feels: the package's force against that of the closed form, over every tick of all
/// trajectories in which either is in contact. Magnitude of the difference of the two vectors,
/// before any cap.
struct ForceErrors {
  double mean_n = 0;
  double rms_n = 0;
  double p95_n = 0;
  double max_n = 0;
  // The same over the just noticeable difference, 7 % of max(|true force|, 0.049 N); 0.049 N is the
  // smallest force that is felt at all. Above 1 the error can be felt.
  double mean_jnd = 0;
  double p95_jnd = 0;
  double max_jnd = 0;
  double contact_differs_percent = 0;  ///< of all ticks: in contact in one of both only
  double max_jump_n = 0;               ///< largest change of the package's force in one tick
  double true_max_jump_n = 0;          ///< of the true force
  int contact_differs_ticks = 0;
  int contact_ticks = 0;  ///< in either
  int ticks = 0;
  int trajectories = 0;
};

/// A figure, its key in JSON and what bounds it (null: nothing does).
template <class Errors>
struct Figure {
  const char* name;
  double Errors::*value;
  LimitMember limit = nullptr;
};

inline constexpr std::array kPhaseFigures{
    Figure<PhaseErrors>{"dice", &PhaseErrors::dice, &Limits::min_dice},
    Figure<PhaseErrors>{"volume_error_ml", &PhaseErrors::volume_error_ml,
                        &Limits::max_volume_error_ml},
    Figure<PhaseErrors>{"volume_error_percent", &PhaseErrors::volume_error_percent,
                        &Limits::max_volume_error_percent},
    Figure<PhaseErrors>{"mean_mm", &PhaseErrors::mean_mm, &Limits::max_mean_mm},
    Figure<PhaseErrors>{"rms_mm", &PhaseErrors::rms_mm, &Limits::max_rms_mm},
    Figure<PhaseErrors>{"p95_mm", &PhaseErrors::p95_mm, &Limits::max_p95_mm},
    Figure<PhaseErrors>{"hausdorff_mm", &PhaseErrors::hausdorff_mm, &Limits::max_hausdorff_mm},
    Figure<PhaseErrors>{"bias_mm", &PhaseErrors::bias_mm, &Limits::max_bias_mm},
    Figure<PhaseErrors>{"normal_mean_deg", &PhaseErrors::normal_mean_deg,
                        &Limits::max_normal_mean_deg},
    Figure<PhaseErrors>{"normal_p95_deg", &PhaseErrors::normal_p95_deg,
                        &Limits::max_normal_p95_deg},
    Figure<PhaseErrors>{"velocity_mean_mm_s", &PhaseErrors::velocity_mean_mm_s,
                        &Limits::max_velocity_mean_mm_s},
    Figure<PhaseErrors>{"velocity_p95_mm_s", &PhaseErrors::velocity_p95_mm_s,
                        &Limits::max_velocity_p95_mm_s},
};

inline constexpr std::array kDrawnFigures{
    Figure<DrawnErrors>{"volume_error_ml", &DrawnErrors::volume_error_ml,
                        &Limits::max_volume_error_ml},
    Figure<DrawnErrors>{"volume_error_percent", &DrawnErrors::volume_error_percent,
                        &Limits::max_volume_error_percent},
    Figure<DrawnErrors>{"mean_mm", &DrawnErrors::mean_mm, &Limits::max_mean_mm},
    Figure<DrawnErrors>{"rms_mm", &DrawnErrors::rms_mm, &Limits::max_rms_mm},
    Figure<DrawnErrors>{"p95_mm", &DrawnErrors::p95_mm, &Limits::max_p95_mm},
    Figure<DrawnErrors>{"hausdorff_mm", &DrawnErrors::hausdorff_mm, &Limits::max_hausdorff_mm},
    Figure<DrawnErrors>{"bias_mm", &DrawnErrors::bias_mm, &Limits::max_bias_mm},
};

inline constexpr std::array kThicknessFigures{
    Figure<ThicknessErrors>{"mean_mm", &ThicknessErrors::mean_mm, &Limits::max_thickness_mean_mm},
    Figure<ThicknessErrors>{"p95_mm", &ThicknessErrors::p95_mm, &Limits::max_thickness_p95_mm},
    Figure<ThicknessErrors>{"bias_mm", &ThicknessErrors::bias_mm, &Limits::max_thickness_bias_mm},
    Figure<ThicknessErrors>{"true_mean_mm", &ThicknessErrors::true_mean_mm},
};

inline constexpr std::array kMotionFigures{
    Figure<MotionErrors>{"mean_mm", &MotionErrors::mean_mm, &Limits::max_motion_mean_mm},
    Figure<MotionErrors>{"p95_mm", &MotionErrors::p95_mm, &Limits::max_motion_p95_mm},
    Figure<MotionErrors>{"tangential_mean_mm", &MotionErrors::tangential_mean_mm},
    Figure<MotionErrors>{"tangential_p95_mm", &MotionErrors::tangential_p95_mm},
    Figure<MotionErrors>{"normal_only_mean_mm", &MotionErrors::normal_only_mean_mm},
    Figure<MotionErrors>{"normal_only_tangential_mean_mm",
                         &MotionErrors::normal_only_tangential_mean_mm},
    Figure<MotionErrors>{"tangential_share", &MotionErrors::tangential_share,
                         &Limits::max_motion_tangential_share},
};

inline constexpr std::array kMapFigures{
    Figure<MapErrors>{"thickness_mean_mm", &MapErrors::thickness_mean_mm,
                      &Limits::max_map_thickness_mean_mm},
    Figure<MapErrors>{"thickness_p95_mm", &MapErrors::thickness_p95_mm,
                      &Limits::max_map_thickness_p95_mm},
    Figure<MapErrors>{"thickness_bias_mm", &MapErrors::thickness_bias_mm},
    Figure<MapErrors>{"thickness_true_mean_mm", &MapErrors::thickness_true_mean_mm},
};

/// Where the map names segments.
inline constexpr std::array kSegmentFigures{
    Figure<MapErrors>{"segments_percent", &MapErrors::segments_percent,
                      &Limits::min_map_segments_percent},
};

inline constexpr std::array kForceFigures{
    Figure<ForceErrors>{"mean_n", &ForceErrors::mean_n, &Limits::max_force_mean_n},
    Figure<ForceErrors>{"rms_n", &ForceErrors::rms_n, &Limits::max_force_rms_n},
    Figure<ForceErrors>{"p95_n", &ForceErrors::p95_n, &Limits::max_force_p95_n},
    Figure<ForceErrors>{"max_n", &ForceErrors::max_n, &Limits::max_force_n},
    Figure<ForceErrors>{"mean_jnd", &ForceErrors::mean_jnd, &Limits::max_force_mean_jnd},
    Figure<ForceErrors>{"p95_jnd", &ForceErrors::p95_jnd, &Limits::max_force_p95_jnd},
    Figure<ForceErrors>{"max_jnd", &ForceErrors::max_jnd},
    Figure<ForceErrors>{"contact_differs_percent", &ForceErrors::contact_differs_percent,
                        &Limits::max_contact_differs_percent},
    Figure<ForceErrors>{"max_jump_n", &ForceErrors::max_jump_n, &Limits::max_force_jump_n},
    Figure<ForceErrors>{"true_max_jump_n", &ForceErrors::true_max_jump_n},
};

/// The line of kLimitNames for a member. @pre it has one (a test holds the tables together)
[[nodiscard]] const LimitName& name_of(LimitMember member);

}  // namespace beatlas::assess
