#include "runtime/app/touch.h"

#include <cstddef>

#include "runtime/base/json_object.h"
#include "runtime/haptics/proxy.h"
#include "runtime/haptics/shell.h"
#include "runtime/haptics/two_step.h"
#include "runtime/palpation/patch_model.h"

namespace beatlas::app {

haptics::Scene make_scene(const std::shared_ptr<const field::FieldQuery>& field,
                          const TouchOptions& options) {
  haptics::Scene scene;
  scene.period_s = field->rr_interval_s();
  if (options.model == "two_step" || options.model == "published") {
    haptics::TwoStepOptions model;
    model.stiffness_n_per_m = options.stiffness_n_per_m;
    model.held_time_s = options.held_time_s;
    if (options.model == "published") model.time_mode = haptics::TimeMode::Published;
    scene.model = std::make_unique<haptics::TwoStepModel>(field, model);
    return scene;
  }
  std::shared_ptr<const haptics::ContactField> body = std::make_shared<haptics::AtlasField>(field);
  if (options.held_time_s) {
    body = std::make_shared<haptics::HeldField>(body, *options.held_time_s);
  }
  if (options.model == "proxy") {
    haptics::ProxyOptions model;
    model.stiffness_n_per_m = options.stiffness_n_per_m;
    model.radius_mm = options.radius_mm;
    model.half_length_mm = options.half_length_mm;
    model.damping_n_s_per_m = options.damping_n_s_per_m;
    model.friction_static = options.friction_static;
    model.friction_dynamic = options.friction_dynamic;
    scene.model = std::make_unique<haptics::ProxyModel>(body, model);
  } else if (options.model == "fingertip") {
    scene.model = std::make_unique<haptics::ShellModel>(
        body, haptics::fingertip(options.radius_mm, static_cast<std::size_t>(options.points)),
        haptics::ShellOptions{.foundation_n_per_m3 = options.foundation_n_per_m3});
  } else if (options.model == "patch") {
    scene.model = std::make_unique<palpation::PatchModel>(
        body, palpation::PatchModelOptions{.long_axis = options.long_axis,
                                           .end_diastole_s = options.end_diastole_s});
  } else {
    throw_invalid("there is no force model " + options.model +
                  "; there are proxy, two_step, published, fingertip and patch");
  }
  return scene;
}

nlohmann::json touch_to_json(const TouchOptions& options) {
  nlohmann::json json = {{"model", options.model},
                         {"stiffness_n_per_m", options.stiffness_n_per_m},
                         {"radius_mm", options.radius_mm},
                         {"half_length_mm", options.half_length_mm},
                         {"damping_n_s_per_m", options.damping_n_s_per_m},
                         {"friction_static", options.friction_static},
                         {"friction_dynamic", options.friction_dynamic},
                         {"points", options.points},
                         {"foundation_n_per_m3", options.foundation_n_per_m3}};
  if (options.model == "patch") {
    json["long_axis"] = options.long_axis;
    json["end_diastole_s"] = options.end_diastole_s;
  }
  if (options.held_time_s) json["held_time_s"] = *options.held_time_s;
  return json;
}

TouchOptions touch_from_json(const nlohmann::json& json) {
  TouchOptions options;
  JsonObject object(json, "/touch");
  object.read("model", options.model);
  object.read("stiffness_n_per_m", options.stiffness_n_per_m, 1, 5000);
  object.read("radius_mm", options.radius_mm, 0, 100);
  object.read("half_length_mm", options.half_length_mm, 0, 100);
  object.read("damping_n_s_per_m", options.damping_n_s_per_m, 0, 100);
  object.read("friction_static", options.friction_static, 0, 1);
  object.read("friction_dynamic", options.friction_dynamic, 0, 1);
  object.read("points", options.points, 1, 10000);
  object.read("foundation_n_per_m3", options.foundation_n_per_m3, 1e3, 1e9);
  object.read("long_axis", options.long_axis, 0, 1);
  object.read("end_diastole_s", options.end_diastole_s, 0, 1e4);
  if (object.has("held_time_s")) {
    options.held_time_s = 0;
    object.read("held_time_s", *options.held_time_s, 0, 1e4);
  }
  object.finish();
  return options;
}

}  // namespace beatlas::app
