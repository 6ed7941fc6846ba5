#pragma once
/// The heart of a package as a session without a picture touches it.

#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "runtime/app/headless.h"
#include "runtime/app/play_options.h"
#include "runtime/app/touch.h"
#include "runtime/atlas/atlas.h"
#include "runtime/field/field_query.h"
#include "runtime/haptics/servo.h"
#include "runtime/haptics/tube_field.h"
#include "runtime/palpation/lv_wall.h"

namespace beatlas::app {

/// Whether paper B's muscle is what is touched.
[[nodiscard]] bool is_patch(const PlayArguments& arguments);

/// One tool on the heart.
struct TouchingTool {
  TouchOptions touch;
  std::unique_ptr<haptics::Servo> servo;
};

/// The structure that is touched: the heart, also from its pericardium, or the cavity that `inside`
/// names.
/// @throws Error{InvalidInput} if there is no such structure
[[nodiscard]] Structure touched_structure(const std::string& inside);

/// What a tool in a cavity needs of a package. @param valve with the way through the LV's valve
[[nodiscard]] atlas::Needs needs_of_inside(const std::string& inside, bool valve);

/// The way through the LV's valve.
/// @param atlas opened with needs_of_inside  @param package its name, for messages
/// @throws Error{InvalidInput} if the package has no map of the LV's wall, or no opening in it
[[nodiscard]] std::shared_ptr<const haptics::TubeField> valve_of(const atlas::Atlas& atlas,
                                                                 const std::string& package);

/// Opened once; any number of tools touch it.
class TouchedHeart {
 public:
  /// @throws Error{InvalidInput} as atlas::Atlas, or if the package lacks the cavity
  explicit TouchedHeart(const PlayArguments& arguments);

  [[nodiscard]] const atlas::Manifest& manifest() const { return atlas_.manifest(); }
  /// Of what is touched.
  [[nodiscard]] const field::FieldQuery& field() const { return *field_; }
  /// @param recorded_ticks as haptics::ServoOptions  @param which as make_scene
  /// @throws Error{InvalidInput} as its parts do
  [[nodiscard]] TouchingTool tool(const PlayArguments& arguments, std::size_t recorded_ticks,
                                  const FingerOfSeveral& which = {}) const;
  /// What several fingers have in common; `finger` is the first.
  /// @throws Error{InvalidInput} as scale_to_atlas, or as pericardial_space_of
  [[nodiscard]] FingerOfSeveral in_common(const PlayArguments& arguments,
                                          std::size_t fingers) const;
  /// [1/min]
  [[nodiscard]] double rate_per_min(const PlayArguments& arguments) const;

 private:
  atlas::Atlas atlas_;
  std::shared_ptr<const field::FieldQuery> field_;
};

/// See schemas/play.schema.json.
[[nodiscard]] nlohmann::json report_json(const PlayArguments& arguments, const TouchOptions& touch,
                                         double rate_per_min, const SessionReport& report);

/// How many of a session's ticks were faults: one in which the force was taken off by a fault is
/// none that went well, whoever reads it.
[[nodiscard]] std::string faults_told(const SessionReport& report);

}  // namespace beatlas::app
