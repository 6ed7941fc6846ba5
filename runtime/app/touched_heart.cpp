#include "runtime/app/touched_heart.h"

#include <algorithm>
#include <optional>

#include "runtime/app/ventricle.h"
#include "runtime/base/error.h"
#include "runtime/haptics/pericardial_field.h"
#include "runtime/palpation/base_opening.h"

namespace beatlas::app {

bool is_patch(const PlayArguments& arguments) {
  return arguments.model == "patch" && !arguments.published;
}

namespace {

atlas::Needs needs_of_scene(const PlayArguments& arguments) {
  if (!arguments.inside.empty() && arguments.scene == "palpation") {
    return needs_of_inside(arguments.inside, arguments.valve);
  }
  if (arguments.scene == "palpation") {
    if (is_patch(arguments)) {
      return needs_of_press(atlas::Atlas::open(arguments.package, atlas::Needs{}).manifest());
    }
    return {.fields = {Structure::Heart}, .surfaces = {}};
  }
  atlas::Needs needs =
      atlas::everything_in(atlas::Atlas::open(arguments.package, atlas::Needs{}).manifest());
  needs.fields.insert(touched_structure(arguments.inside));
  needs.volume = false;  // nothing is drawn here
  needs.levels = {0};
  return needs;
}

TouchOptions touch_options(const PlayArguments& arguments, const atlas::Manifest& manifest,
                           const field::FieldQuery& field) {
  TouchOptions touch;
  touch.model = arguments.published ? "published" : arguments.model;
  touch.inside = arguments.inside;
  touch.valve = arguments.valve;
  touch.effusion_mm = arguments.effusion_mm;
  touch.stiffness_n_per_m = manifest.stiffness_n_per_m;
  touch.radius_mm = arguments.tool_radius_mm;
  if (touch.model == "fingertip" && touch.radius_mm == 0) touch.radius_mm = 8;
  touch.half_length_mm = arguments.tool_half_length_mm;
  touch.damping_n_s_per_m = arguments.damping_n_s_per_m;
  touch.friction_static = arguments.friction_static;
  touch.friction_dynamic = arguments.friction_dynamic;
  touch.points = arguments.tool_points;
  const double end_diastole_s = manifest.rr_interval_s * manifest.end_diastole / field.phases();
  touch.long_axis = arguments.long_axis;
  touch.end_diastole_s = end_diastole_s;
  if (arguments.held) touch.held_time_s = end_diastole_s;
  return touch;
}

}  // namespace

Structure touched_structure(const std::string& inside) {
  if (inside.empty() || inside == kPericardium) return Structure::Heart;
  const std::optional<Structure> structure = structure_from_name(inside);
  if (!structure) throw_invalid("there is no structure " + inside + " to be in");
  return *structure;
}

atlas::Needs needs_of_inside(const std::string& inside, bool valve) {
  atlas::Needs needs{.fields = {touched_structure(inside)}, .surfaces = {}};
  if (valve) {
    needs.surfaces.insert(Structure::LvBlood);
    needs.maps.insert(Structure::LvBlood);
    needs.levels = {0};
  }
  return needs;
}

std::shared_ptr<const haptics::TubeField> valve_of(const atlas::Atlas& atlas,
                                                   const std::string& package) {
  const auto map = atlas.surface_map(Structure::LvBlood);
  if (!map) {
    throw_invalid(package +
                  " has no map of the LV's wall, which shows where its valve is; build it with the "
                  "scene full, or leave --valve out");
  }
  try {
    return std::make_shared<const haptics::TubeField>(
        palpation::base_opening(*atlas.surface(Structure::LvBlood), *map),
        atlas.manifest().rr_interval_s);
  } catch (const Error& error) {
    throw Error(error.code(), package + ": " + error.what());
  }
}

TouchedHeart::TouchedHeart(const PlayArguments& arguments)
    : atlas_(atlas::Atlas::open(arguments.package, needs_of_scene(arguments))),
      field_(std::make_shared<const field::FieldQuery>(
          atlas_.field(touched_structure(arguments.inside)), manifest().rr_interval_s)) {}

FingerOfSeveral TouchedHeart::in_common(const PlayArguments& arguments, std::size_t fingers) const {
  FingerOfSeveral out;
  if (arguments.inside == kPericardium) {
    out.pericardium = haptics::pericardial_space_of(field_, arguments.effusion_mm);
  }
  // A heart that stands still has no blood to give to another place.
  if (!is_patch(arguments) || arguments.held) return out;
  TouchOptions touch;
  (void)take_muscle(told_muscle(arguments.press.parameters, arguments.press.preset), atlas_,
                    arguments.package, touch);
  using C = palpation::CirculationParameters;
  touch.parameters.circulation.heart_rate_per_min =
      std::clamp(rate_per_min(arguments), C::kSlowestPerMin, C::kQuickestPerMin);
  out.circulation = std::make_shared<palpation::CommonCirculation>(
      touch.parameters, static_cast<double>(manifest().end_diastole) / field_->phases(), fingers);
  return out;
}

TouchingTool TouchedHeart::tool(const PlayArguments& arguments, std::size_t recorded_ticks,
                                const FingerOfSeveral& which) const {
  TouchingTool out;
  out.touch = touch_options(arguments, manifest(), *field_);
  std::shared_ptr<const palpation::LvWall> wall;
  if (is_patch(arguments)) {
    wall = take_muscle(told_muscle(arguments.press.parameters, arguments.press.preset), atlas_,
                       arguments.package, out.touch);
  }
  haptics::ServoOptions options;
  if (arguments.heart_rate_per_min > 0) options.heart.rate_per_min = arguments.heart_rate_per_min;
  options.recorded_ticks = recorded_ticks;
  const auto valve = out.touch.valve ? valve_of(atlas_, arguments.package) : nullptr;
  try {
    out.servo = std::make_unique<haptics::Servo>(make_scene(field_, out.touch, wall, valve, which),
                                                 options);
  } catch (const Error& error) {
    throw error.with_context(arguments.package);
  }
  return out;
}

double TouchedHeart::rate_per_min(const PlayArguments& arguments) const {
  return arguments.heart_rate_per_min > 0 ? arguments.heart_rate_per_min
                                          : 60 / manifest().rr_interval_s;
}

nlohmann::json report_json(const PlayArguments& arguments, const TouchOptions& touch,
                           double rate_per_min, const SessionReport& report) {
  nlohmann::json json = session_json(report);
  json["scene"] = arguments.scene;
  json["model"] = touch.model;
  if (!touch.inside.empty()) {
    json["inside"] = touch.inside;
    if (touch.effusion_mm > 0) {
      json["effusion_mm"] = touch.effusion_mm;
    } else {
      json["valve"] = touch.valve ? "open" : "closed";
    }
  }
  json["tool_radius_mm"] = touch.radius_mm;
  json["heart_rate_per_min"] = rate_per_min;
  json["time_mode"] = touch.model == "published" ? "published" : "continuous";
  json["heart"] = arguments.held ? "held" : "beating";
  json["pace"] = arguments.fast ? "fast" : "real_time";
  json["stiffness_n_per_m"] = touch.stiffness_n_per_m;
  return json;
}

std::string faults_told(const SessionReport& report) {
  return std::to_string(report.faults) + " of " + std::to_string(report.run.ticks) +
         (report.faults == 1 ? " ticks was a fault and had no force"
                             : " ticks were faults and had no force");
}

}  // namespace beatlas::app
