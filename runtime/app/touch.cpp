#include "runtime/app/touch.h"

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/json_object.h"
#include "runtime/haptics/cavity_field.h"
#include "runtime/haptics/pericardial_field.h"
#include "runtime/haptics/proxy.h"
#include "runtime/haptics/shell.h"
#include "runtime/haptics/two_step.h"
#include "runtime/palpation/patch_model.h"

namespace beatlas::app {

namespace {

using nlohmann::json;

// Runs of vertices of the same tissue: [count, scar, thickness ratio, alpha, stiffness ratio];
// files from before there was the last one are without it.
json tissue_to_json(const palpation::TissueMap& map) {
  json runs = json::array();
  const std::vector<palpation::Tissue>& all = map.of_vertex;
  for (std::size_t first = 0; first < all.size();) {
    std::size_t end = first;
    while (end < all.size() && all[end] == all[first]) ++end;
    runs.push_back({end - first, all[first].scar, all[first].thickness_ratio, all[first].alpha,
                    all[first].stiffness_ratio});
    first = end;
  }
  return {{"runs", runs}, {"infarct", {map.infarct.fraction, map.infarct.alpha}}};
}

palpation::TissueMap tissue_from_json(const json& document, const std::string& path) {
  constexpr double kMostVertices = 1e7;
  const auto within = [&](const json& value, const std::string& where, double low, double high) {
    if (!value.is_number() || !(value.get<double>() >= low && value.get<double>() <= high)) {
      throw_invalid(where + " is no number in range; was the file changed?");
    }
    return value.get<double>();
  };
  JsonObject object(document, path);
  const json& runs = object.at("runs");
  const json& infarct = object.at("infarct");
  object.finish();
  palpation::TissueMap out;
  if (!runs.is_array()) throw_invalid(path + "/runs must be a list");
  for (std::size_t n = 0; n < runs.size(); ++n) {
    const std::string where = path + "/runs/" + std::to_string(n);
    if (!runs[n].is_array() || (runs[n].size() != 4 && runs[n].size() != 5)) {
      throw_invalid(where + " must be five numbers");
    }
    const auto count = static_cast<std::size_t>(within(runs[n][0], where, 1, kMostVertices));
    if (out.of_vertex.size() + count > static_cast<std::size_t>(kMostVertices)) {
      throw_invalid(path + "/runs are of more vertices than any atlas has");
    }
    out.of_vertex.resize(out.of_vertex.size() + count,
                         {.scar = within(runs[n][1], where, 0, 1),
                          .thickness_ratio = within(runs[n][2], where, 0.3, 2),
                          .alpha = within(runs[n][3], where, 0, 1),
                          .stiffness_ratio = runs[n].size() == 5 ? within(runs[n][4], where,
                                                                          palpation::kSoftestRatio,
                                                                          palpation::kStiffestRatio)
                                                                 : 1});
  }
  if (!infarct.is_array() || infarct.size() != 2) {
    throw_invalid(path + "/infarct must be two numbers");
  }
  out.infarct = {.fraction = within(infarct[0], path + "/infarct", 0, 1),
                 .alpha = within(infarct[1], path + "/infarct", 0, 1)};
  return out;
}

}  // namespace

haptics::Scene make_scene(const std::shared_ptr<const field::FieldQuery>& field,
                          const TouchOptions& options,
                          const std::shared_ptr<const palpation::LvWall>& wall,
                          const std::shared_ptr<const haptics::TubeField>& valve,
                          const FingerOfSeveral& which) {
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
  std::shared_ptr<const haptics::ContactField> body;
  if (options.inside == kPericardium) {
    body = which.pericardium ? which.pericardium
                             : haptics::pericardial_space_of(field, options.effusion_mm);
  } else if (!options.inside.empty()) {
    body = haptics::cavity_of(field, valve);
  } else {
    body = std::make_shared<const haptics::AtlasField>(field);
  }
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
    palpation::PatchModelOptions model{.parameters = options.parameters,
                                       .long_axis = options.long_axis,
                                       .end_diastole_s = options.end_diastole_s,
                                       .radius_mm = options.radius_mm,
                                       .circulation = which.circulation,
                                       .finger = which.finger};
    if (!options.tissue.of_vertex.empty()) {
      model.muscle =
          std::make_shared<palpation::AtlasMuscle>(wall, options.tissue, options.parameters);
    }
    scene.model = std::make_unique<palpation::PatchModel>(body, model);
  } else {
    throw_invalid("there is no force model " + options.model +
                  "; there are proxy, two_step, published, fingertip and patch");
  }
  return scene;
}

std::shared_ptr<const palpation::LvWall> take_muscle(const ToldMuscle& told,
                                                     const atlas::Atlas& atlas,
                                                     const std::string& package,
                                                     TouchOptions& options) {
  std::optional<AtlasVentricle> ventricle = ventricle_of(atlas, told, package);
  options.parameters = told.parameters;
  if (ventricle) options.parameters.infarct = ventricle->tissue.infarct;
  scale_to_atlas(options.parameters, atlas.manifest(), package);
  if (!ventricle) return nullptr;
  options.tissue = std::move(ventricle->tissue);
  return ventricle->wall;
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
    json["parameters"] = palpation::palpation_to_json(options.parameters);
    if (!options.tissue.of_vertex.empty()) json["tissue"] = tissue_to_json(options.tissue);
  }
  if (options.held_time_s) json["held_time_s"] = *options.held_time_s;
  if (!options.inside.empty()) json["inside"] = options.inside;
  if (options.valve) json["valve"] = true;
  if (options.effusion_mm > 0) json["effusion_mm"] = options.effusion_mm;
  return json;
}

TouchOptions touch_from_json(const nlohmann::json& json) {
  TouchOptions options;
  JsonObject object(json, "/touch");
  object.read("model", options.model);
  object.read("inside", options.inside);
  object.read("valve", options.valve);
  object.read("effusion_mm", options.effusion_mm, 0, haptics::PericardialOptions::kThickestMm);
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
  if (object.has("parameters")) {
    options.parameters = palpation::palpation_from_json(object.at("parameters"));
  }
  if (object.has("tissue")) {
    options.tissue = tissue_from_json(object.at("tissue"), "/touch/tissue");
    options.parameters.infarct = options.tissue.infarct;
  }
  if (object.has("held_time_s")) {
    options.held_time_s = 0;
    object.read("held_time_s", *options.held_time_s, 0, 1e4);
  }
  object.finish();
  return options;
}

}  // namespace beatlas::app
