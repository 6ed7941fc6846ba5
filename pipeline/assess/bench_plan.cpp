#include "pipeline/assess/bench_plan.h"

#include <algorithm>
#include <array>

#include "runtime/base/error.h"

namespace beatlas::assess {
using nlohmann::json;
namespace {

std::vector<Knob> published_knobs() {
  using enum Sweep;
  using enum Family;
  return {
      {"published", "paper A's method", Exact, Published, {}},
      {"published", "paper A's method", Images, Published, {}},
  };
}

/// How finely the field is sampled, rounded and read, and how far it reaches about the surface.
std::vector<Knob> sampling_knobs() {
  using enum Sweep;
  using enum Family;
  const KnobAxis space{
      "/query/space", {"nearest", "trilinear", "cubic"}, {"nearest", "trilinear", "cubic"}};
  const KnobAxis time{"/query/time", {"nearest", "linear", "cubic"}, {"linear", "cubic"}};
  // Below 1.5 mm only from the exact shape: from images the segmentation's error hides the gain.
  return {
      {"voxel",
       "field voxel [mm]",
       Exact,
       Field,
       {{"/field/voxel_mm", {0.5, 1.0, 1.5, 2.0, 3.0}, {1.5, 3.0}}}},
      {"voxel",
       "field voxel [mm]",
       Images,
       Field,
       {{"/field/voxel_mm", {1.5, 2.0, 3.0}, {1.5, 3.0}}},
       false},
      {"interpolation", "interpolation in space, in time", Exact, Field, {space, time}},
      {"interpolation", "interpolation in space, in time", Images, Field, {space, time}},
      {"voxel-space",
       "field voxel [mm], interpolation in space",
       Exact,
       Field,
       {{"/field/voxel_mm", {1.0, 1.5, 2.0, 3.0}, {1.5, 3.0}}, space}},
      {"band-inner",
       "depth of the band [mm]",
       Exact,
       Field,
       {{"/field/inner_mm", {6.0, 10.0, 15.0, 25.0}, {6.0, 15.0}}},
       false},
      {"band-outer",
       "height of the band [mm]",
       Exact,
       Field,
       {{"/field/outer_mm", {3.0, 6.0, 10.0}, {3.0, 6.0}}},
       false},
      {"quantisation",
       "step of the field [mm]",
       Exact,
       Field,
       {{"/pack/step_mm", {0.005, 0.02, 0.05, 0.1}, {0.02, 0.1}}},
       false},
  };
}

/// What decides how well images give the shape of which the field is made.
std::vector<Knob> image_knobs() {
  using enum Sweep;
  using enum Family;
  return {
      {"shape",
       "lattice of the shapes [mm]",
       Images,
       Field,
       {{"/register/shape_mm", {1.0, 1.5, 2.0}, {1.0, 2.0}}},
       false},
      {"edge-cost",
       "growing: cost of an edge [mm]",
       Images,
       Field,
       {{"/segment/edge_cost_mm", {5.0, 20.0}, {5.0, 20.0}}},
       false},
      {"outline",
       "growing: smoothing of outlines [mm]",
       Images,
       Field,
       {{"/segment/outline_sigma_mm", {1.0, 2.0, 4.0}, {1.0, 2.0}}}},
      {"motion",
       "growing: along the motion",
       Images,
       Field,
       {{"/segment/follow_motion", {true, false}, {true, false}}},
       false},
      {"flicker",
       "noise from phase to phase in the field",
       Images,
       Field,
       {{"/field/flicker", {"remove", "keep"}, {"remove", "keep"}}},
       false},
      {"matrix",
       "image matrix, times the preset's",
       Images,
       Field,
       {{"/phantom/matrix", {0.75, 1.0, 1.4}, {0.75, 1.0}}}},
  };
}

/// How small surfaces and volumes, the payloads beside the field, are made.
std::vector<Knob> payload_knobs() {
  using enum Sweep;
  using enum Family;
  return {
      {"mesh-edge",
       "triangle edge [mm]",
       Exact,
       Surface,
       {{"/mesh/edge_mm", {1.5, 2.0, 4.0}, {2.0, 4.0}}}},
      {"level-of-detail",
       "level of detail: triangle edge [mm]",
       Exact,
       Surface,
       {{"/level/edge_mm", {2.0, 3.0, 4.0, 8.0}, {2.0, 4.0}}}},
      {"draco",
       "step of surfaces [mm]",
       Exact,
       Surface,
       {{"/pack/surface_step_mm", {0.0025, 0.01, 0.04, 0.16}, {0.01, 0.16}}}},
      {"volume-step",
       "step of the volume, times the noise",
       Images,
       Volume,
       {{"/pack/volume_step", {0.5, 1.0, 2.0, 4.0, 8.0}, {2.0, 8.0}}}},
  };
}

/// @throws Error{Usage} for a name that is no knob's, listing those that are.
void check_names(const std::vector<Knob>& knobs, const std::vector<std::string>& only) {
  for (const std::string& name : only) {
    if (std::any_of(knobs.begin(), knobs.end(), [&](const Knob& k) { return k.name == name; })) {
      continue;
    }
    std::string known;
    for (const Knob& knob : knobs) {
      if (known.find(knob.name + ",") != std::string::npos) continue;
      known += knob.name + ", ";
    }
    known.resize(known.size() - 2);
    throw Error(
        ErrorCode::Usage,
        std::string("there is no knob '").append(name).append("'; choose of ").append(known));
  }
}

/// Every value of each of a knob's axes with every value of the others.
std::vector<BenchRun> runs_of(const Knob& knob, const json& defaults, bool quick) {
  std::vector<BenchRun> made{{knob.name, knob.title, knob.sweep, knob.family, json::object(),
                              defaults, true, knob.ventricles}};
  for (const KnobAxis& axis : knob.axes) {
    const json::json_pointer pointer(axis.pointer);
    std::vector<BenchRun> next;
    for (const BenchRun& run : made) {
      for (const json& value : quick ? axis.quick : axis.values) {
        next.push_back(run);
        next.back().values[axis.pointer] = value;
        next.back().settings[pointer] = value;
        next.back().is_default = run.is_default && defaults.at(pointer) == value;
      }
    }
    made = std::move(next);
  }
  for (BenchRun& run : made) run.ventricles = run.ventricles || run.is_default;
  return made;
}

}  // namespace

const std::vector<Knob>& bench_knobs() {
  static const std::vector<Knob> knobs = [] {
    std::vector<Knob> all = published_knobs();
    for (const std::vector<Knob>& more : {sampling_knobs(), image_knobs(), payload_knobs()}) {
      all.insert(all.end(), more.begin(), more.end());
    }
    return all;
  }();
  return knobs;
}

std::vector<std::string> bench_knob_names() {
  std::vector<std::string> out;
  for (const Knob& knob : bench_knobs()) {
    if (std::find(out.begin(), out.end(), knob.name) == out.end()) out.push_back(knob.name);
  }
  return out;
}

std::vector<BenchRun> plan_runs(const std::vector<Knob>& knobs,
                                const std::vector<std::string>& only, const json& defaults,
                                bool quick) {
  check_names(knobs, only);
  std::vector<BenchRun> runs;
  for (const Knob& knob : knobs) {
    if (!only.empty() && std::find(only.begin(), only.end(), knob.name) == only.end()) continue;
    const std::vector<BenchRun> made = runs_of(knob, defaults, quick);
    runs.insert(runs.end(), made.begin(), made.end());
  }
  return runs;
}

std::string first_difference(const json& one, const json& other) {
  for (const char* stage :
       {"phantom", "segment", "register", "field", "mesh", "level", "pack", "query"}) {
    if (one.value(stage, json()) != other.value(stage, json())) return stage;
  }
  return "";
}

std::string_view sweep_name(Sweep sweep) { return sweep == Sweep::Images ? "images" : "exact"; }

std::string_view family_name(Family family) {
  switch (family) {
    case Family::Field:
      return "field";
    case Family::Surface:
      return "surface";
    case Family::Volume:
      return "volume";
    case Family::Published:
      break;
  }
  return "published";
}

}  // namespace beatlas::assess
