#include "runtime/app/play_options.h"

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "runtime/app/touch.h"
#include "runtime/atlas/structures.h"
#include "runtime/base/error.h"
#include "runtime/haptics/pericardial_field.h"
#include "runtime/palpation/parameters.h"
#include "runtime/palpation/segments.h"

namespace beatlas::app {
namespace {

std::vector<std::string> segment_names() {
  std::vector<std::string> out;
  for (int segment = 1; segment <= palpation::kSegments; ++segment) {
    out.emplace_back(palpation::segment_name(segment));
  }
  return out;
}

}  // namespace

std::vector<std::string> cavity_names() {
  std::vector<std::string> out;
  for (const Structure ventricle : {Structure::LvBlood, Structure::RvBlood}) {
    out.emplace_back(structure_name(ventricle));
  }
  out.emplace_back(kPericardium);
  return out;
}

void check_inside(const std::string& inside, bool valve, double effusion_mm) {
  if (valve && inside != structure_name(Structure::LvBlood)) {
    throw Error(ErrorCode::Usage, "--valve is the left ventricle's; use it with --inside lv_blood");
  }
  if ((inside == kPericardium) != (effusion_mm > 0)) {
    throw Error(ErrorCode::Usage,
                "--inside pericardium and --effusion-mm belong together: an atlas does not show "
                "how thick the fluid is; give both or neither");
  }
}

namespace {

/// What moves the user point, and where it is found.
void add_device_options(CLI::App& app, PlayArguments& arguments) {
  app.add_option("--device", arguments.device, "what moves the user point")
      ->check(CLI::IsMember({"simulated", "replay", "trainee", "haply", "3ds", "dhd", "lever"}))
      ->capture_default_str();
  app.add_flag("--list-devices", arguments.list_devices, "say which devices are there, and end");
  app.add_option("--device-library", arguments.hardware.library,
                 "3ds, dhd: the vendor's library, if it is not where the system looks");
  app.add_option("--device-name", arguments.hardware.name, "3ds, haply: which one of several");
  app.add_option("--haply-host", arguments.hardware.host, "where Haply's service runs")
      ->capture_default_str();
  app.add_option("--haply-port", arguments.hardware.port, "its port")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  app.add_option("--lever-line", arguments.hardware.line,
                 "lever: its serial line, angles [rad] in and torques [N m] out, a line each");
  app.add_option("--lever-arm-mm", arguments.hardware.arm_mm, "lever: from hinge to finger")
      ->check(CLI::Range(5.0, 1000.0))
      ->capture_default_str();
}

/// How the user point moves where no person moves it, and for how long.
void add_path_options(CLI::App& app, PlayArguments& arguments) {
  app.add_option("--recording", arguments.recording,
                 "replay: CSV with columns t_s, x_mm, y_mm, z_mm (workspace)");
  app.add_option("--seconds", arguments.seconds, "how long [s]; a recording has its own end")
      ->check(CLI::Range(0.001, 36000.0))
      ->capture_default_str();
  app.add_option("--hand", arguments.hand, "simulated: a still hand or sinusoidal palpation")
      ->check(CLI::IsMember({"still", "palpation"}))
      ->capture_default_str();
  app.add_option("--side", arguments.side, "side of the body that is pressed")
      ->check(CLI::IsMember({"left", "right", "anterior", "posterior", "superior", "inferior"}))
      ->capture_default_str();
  app.add_option("--depth-mm", arguments.depth_mm,
                 "simulated: middle of the path below the end-diastolic surface")
      ->check(CLI::Range(-50.0, 50.0))
      ->capture_default_str();
  app.add_option("--amplitude-mm", arguments.amplitude_mm, "simulated: of palpation")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  app.add_option("--frequency-hz", arguments.frequency_hz, "simulated: of palpation")
      ->check(CLI::Range(0.0, 20.0))
      ->capture_default_str();
  app.add_option("--mass-kg", arguments.mass_kg,
                 "simulated: mass of hand and stylus that the force moves; 0 follows the path")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
}

/// Which heart is touched, by which model, and where the tool is.
void add_contact_options(CLI::App& app, PlayArguments& arguments) {
  app.add_flag("--fast", arguments.fast, "do not wait for the clock");
  app.add_flag("--published", arguments.published,
               "force at the stored frames, interpolated linearly (Nakao et al. 2001)");
  app.add_flag("--held", arguments.held, "the heart stands still at end-diastole");
  app.add_option("--model", arguments.model,
                 "proxy: a point or sphere the surface carries along; two_step: depth along the "
                 "distance's gradient; fingertip: an area of points; patch: paper B's muscle")
      ->check(CLI::IsMember({"proxy", "two_step", "fingertip", "patch"}))
      ->capture_default_str();
  app.add_option(
         "--inside", arguments.inside,
         "a cavity that the tool is in, with --model proxy or fingertip; without, the heart "
         "is touched from outside")
      ->check(CLI::IsMember(cavity_names()));
  app.add_flag("--valve", arguments.valve,
               "with --inside lv_blood: the tool may come and go through the valve at its base");
  app.add_option("--effusion-mm", arguments.effusion_mm,
                 "with --inside pericardium: the fluid's thickness around the heart at its largest")
      ->check(CLI::Range(haptics::PericardialOptions::kThinnestMm,
                         haptics::PericardialOptions::kThickestMm));
  app.add_option("--long-axis", arguments.long_axis,
                 "patch: 0 apex to 1 base, whose muscle it is where the package has no map")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
}

/// The tool, and how the tissue drags on it.
void add_tool_options(CLI::App& app, PlayArguments& arguments) {
  app.add_option("--tool-radius-mm", arguments.tool_radius_mm,
                 "proxy, patch: 0 is a point; fingertip: 0 is 8 mm")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  app.add_option("--tool-half-length-mm", arguments.tool_half_length_mm,
                 "proxy: of a capsule, whose axis is the tool's z; 0 is a sphere")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  app.add_option("--tool-points", arguments.tool_points, "fingertip: how many")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app.add_option("--damping-n-s-per-m", arguments.damping_n_s_per_m, "proxy: of the tissue")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  app.add_option("--friction-static", arguments.friction_static, "proxy: while the tool sticks")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--friction-dynamic", arguments.friction_dynamic,
                 "proxy: while it slides; at most the static one")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
}

/// A scripted press, and the muscle that is pressed.
void add_press_options(CLI::App& app, PlayArguments& arguments) {
  app.add_option("--press", arguments.press.folder,
                 "folder for a scripted press on paper B's ventricle (or on one as large as the "
                 "package's): CSV and SVG; with --scene palpation and no package: palpation/");
  app.add_option("--press-depth-mm", arguments.press.script.depth_mm, "how deep")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  app.add_option("--press-segment", arguments.press.segment,
                 "AHA segment that is pressed, by name; if not said mid_anterior, or on a package "
                 "the first of the "
                 "free wall that a finger reaches")
      ->check(CLI::IsMember(segment_names()));
  app.add_option("--parameters", arguments.press.parameters,
                 "JSON of muscle, circulation and disease, for --press or --model patch");
  app.add_option("--preset", arguments.press.preset, "of them, for --press or --model patch")
      ->check(CLI::IsMember(palpation::palpation_presets()));
}

/// What files of JSON tell: a case, several fingers, an exercise and how that is played.
void add_case_options(CLI::App& app, PlayArguments& arguments) {
  app.add_option(
      "--case", arguments.case_file,
      "JSON of a heart and what was felt on it: its atlas, unless a PACKAGE is named, with "
      "paper B's muscle as it says");
  app.add_option(
         "--fingers", arguments.fingers,
         "JSON of two to eight devices that touch this heart at once; in the window as well")
      ->check([](const std::string& file) { return file.empty() ? "names no file" : ""; });
  app.add_option("--exercise", arguments.exercise,
                 "JSON of what is hidden in this heart to be found by touch, with --session");
  app.add_option("--session", arguments.session,
                 "folder in which the exercise is kept; one that was broken off goes on");
  app.add_option("--seed", arguments.seed, "exercise: what is hidden; if not said, by chance")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 53));
  app.add_flag("--window", arguments.window, "exercise: in a window, with the mouse or a device");
  app.add_option("--trainee", arguments.trainee, "trainee: how well it palpates")
      ->check(CLI::IsMember({"skilled", "unskilled"}))
      ->capture_default_str();
}

}  // namespace

void add_play_options(CLI::App& app, PlayArguments& arguments) {
  app.add_option("PACKAGE", arguments.package, "a .beatlas file");
  app.add_flag("--headless", arguments.headless, "no picture: run the servo and report");
  app.add_option("--scene", arguments.scene,
                 "what to load: palpation (the heart's field) or full (every payload)")
      ->check(CLI::IsMember({"palpation", "full"}))
      ->capture_default_str();
  add_device_options(app, arguments);
  add_path_options(app, arguments);
  add_contact_options(app, arguments);
  add_tool_options(app, arguments);
  app.add_option("--heart-rate", arguments.heart_rate_per_min,
                 "beats a minute instead of the atlas's own")
      ->check(CLI::Range(10.0, 300.0));
  app.add_option("--trace", arguments.trace, "CSV of every tick to write");
  app.add_option("--ticks", arguments.ticks,
                 "file for the first fault's ticks, or the last 10000: for replay-ticks");
  app.add_flag("--json", arguments.json, "report as JSON");
  add_press_options(app, arguments);
  add_case_options(app, arguments);
}

}  // namespace beatlas::app
