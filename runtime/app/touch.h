#pragma once
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "runtime/app/ventricle.h"
#include "runtime/field/field_query.h"
#include "runtime/haptics/servo.h"
#include "runtime/haptics/tube_field.h"
#include "runtime/palpation/common_circulation.h"

namespace beatlas::app {

/// What a tool can be in beside cavities; no structure of an atlas.
inline constexpr std::string_view kPericardium = "pericardium";

/// How a structure is touched; what a session and the replay of its ticks must agree on.
struct TouchOptions {
  std::string model =
      "proxy";  ///< proxy, two_step, published (Nakao et al. 2001), fingertip or patch
  /// proxy, fingertip: the structure whose wall is touched from within; none: the heart, from
  /// outside
  std::string inside;
  bool valve = false;      ///< inside the LV: its valve is open to the tool
  double effusion_mm = 0;  ///< inside the pericardium: how thick the fluid is
  double stiffness_n_per_m = 150;
  double radius_mm = 0;                ///< proxy, patch: of a ball, 0 a point; fingertip: its own
  double half_length_mm = 0;           ///< proxy: of a capsule, 0 none
  double damping_n_s_per_m = 0;        ///< proxy
  double friction_static = 0;          ///< proxy
  double friction_dynamic = 0;         ///< proxy
  int points = 2000;                   ///< fingertip
  double foundation_n_per_m3 = 1.5e6;  ///< fingertip
  double long_axis = 0.5;              ///< patch, without a map: 0 apex .. 1 base, whose muscle
  double end_diastole_s = 0;           ///< patch: where contraction begins
  palpation::PalpationParameters parameters = {};  ///< patch
  palpation::TissueMap tissue = {};                ///< patch: of the wall's vertices; none: no map
  std::optional<double> held_time_s = std::nullopt;  ///< the heart stands still at this time
};

/// Which finger of several this is, and what they have in common.
struct FingerOfSeveral {
  std::shared_ptr<palpation::CommonCirculation> circulation = nullptr;  ///< patch
  /// Inside the pericardium: null, it is made, which takes a while
  std::shared_ptr<const haptics::ContactField> pericardium = nullptr;
  std::size_t finger = 0;
};

/// @param field of what is touched: of the heart, or of the cavity that options.inside names
/// @param wall whose vertices options.tissue is of; null without
/// @param valve the way out of the cavity that options.inside names; null without options.valve
/// @param which without a circulation: the finger feels the natural beat
/// @throws Error{InvalidInput} as the models do.
[[nodiscard]] haptics::Scene make_scene(
    const std::shared_ptr<const field::FieldQuery>& field, const TouchOptions& options,
    const std::shared_ptr<const palpation::LvWall>& wall = nullptr,
    const std::shared_ptr<const haptics::TubeField>& valve = nullptr,
    const FingerOfSeveral& which = {});

/// Puts the muscle of the package's own ventricle, as ill as it is told to be, into `options`.
/// @param atlas opened with needs_of_press  @param package its name, for messages
/// @return the wall, for make_scene; null without a map
/// @throws Error{InvalidInput} as ventricle_of and scale_to_atlas
std::shared_ptr<const palpation::LvWall> take_muscle(const ToldMuscle& told,
                                                     const atlas::Atlas& atlas,
                                                     const std::string& package,
                                                     TouchOptions& options);

[[nodiscard]] nlohmann::json touch_to_json(const TouchOptions& options);
/// @throws Error{InvalidInput} naming the JSON path of what is missing, unknown or out of range.
[[nodiscard]] TouchOptions touch_from_json(const nlohmann::json& json);

}  // namespace beatlas::app
