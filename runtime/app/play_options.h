#pragma once
/// What `beatlas-play` is told on its command line, its subcommands apart.

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/app/press_session.h"
#include "runtime/device/hardware.h"

namespace CLI {
class App;
}

namespace beatlas::app {

struct PlayArguments {
  std::string package;
  bool headless = false;
  std::string device = "simulated";
  std::string scene = "palpation";
  std::string recording;
  std::string hand = "palpation";
  std::string side = "left";
  double seconds = 10;
  double depth_mm = 4;
  double amplitude_mm = 4;
  double frequency_hz = 1.5;
  double mass_kg = 0;
  bool fast = false;
  bool published = false;
  bool held = false;
  /// A cavity that the tool is in, or the pericardium; none: the heart is touched from outside
  std::string inside;
  bool valve = false;      ///< inside lv_blood: the way through its valve is open
  double effusion_mm = 0;  ///< inside the pericardium: how thick its fluid is
  std::string model = "proxy";
  bool model_named = false;
  double tool_radius_mm = 0;
  double tool_half_length_mm = 0;
  double long_axis = 0.5;
  double damping_n_s_per_m = 0;
  double friction_static = 0;
  double friction_dynamic = 0;
  int tool_points = 2000;
  double heart_rate_per_min = 0;
  std::string trace;
  std::string ticks;
  device::HardwareOptions hardware;
  bool list_devices = false;
  bool json = false;
  bool scene_named = false;
  PressArguments press;
  std::string case_file;            ///< JSON after schemas/case.schema.json; or none
  std::string fingers;              ///< JSON after schemas/fingers.schema.json; or none
  std::string exercise;             ///< JSON after schemas/exercise.schema.json; or none
  std::string session;              ///< folder in which an exercise is kept
  std::int64_t seed = -1;           ///< of what an exercise hides; below 0: by chance
  bool window = false;              ///< an exercise is seen
  std::string trainee = "skilled";  ///< of the device `trainee`
};

/// What a tool can be in: the ventricles, which scenes hold fields of, and the pericardium.
[[nodiscard]] std::vector<std::string> cavity_names();
/// @throws Error{Usage} if the three do not go together
void check_inside(const std::string& inside, bool valve, double effusion_mm);

void add_play_options(CLI::App& app, PlayArguments& arguments);

}  // namespace beatlas::app
