#include "runtime/app/play.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <istream>
#include <memory>
#include <new>
#include <ostream>
#include <sstream>
#include <string>

#include <CLI/CLI.hpp>

#include "runtime/app/headless.h"
#include "runtime/app/probe.h"
#include "runtime/app/text.h"
#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"
#include "runtime/device/replay.h"
#include "runtime/device/simulated.h"

namespace beatlas::app {
namespace {

struct ProbeArguments {
  std::string package;
  std::string points;
  std::string output;
  std::string structure = "heart";
  std::string frame = "workspace";
};

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
  std::string trace;
  bool json = false;
};

[[noreturn]] void throw_usage(const std::string& message) {
  throw Error(ErrorCode::Usage, message);
}

std::ifstream open_text(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw_invalid(file + " cannot be read; check its name and rights");
  return stream;
}

void run_probe(const ProbeArguments& arguments, std::istream& in, std::ostream& out) {
  const auto structure = structure_from_name(arguments.structure);
  if (!structure) throw_usage("--structure: there is no structure " + arguments.structure);
  const atlas::Atlas atlas =
      atlas::Atlas::open(arguments.package, {.fields = {*structure}, .surfaces = {}});
  const atlas::Manifest& manifest = atlas.manifest();
  const field::FieldQuery field(atlas.field(*structure), manifest.rr_interval_s);
  const ProbeOptions options{.stiffness_n_per_m = manifest.stiffness_n_per_m,
                             .lps = arguments.frame == "lps",
                             .workspace_from_lps = manifest.workspace_from_lps};
  std::ostringstream text;
  if (arguments.points == "-") {
    probe(field, options, in, "standard input", text);
  } else {
    std::ifstream points = open_text(arguments.points);
    probe(field, options, points, arguments.points, text);
  }
  if (arguments.output.empty()) {
    out << text.str();
  } else {
    write_file(arguments.output, text.str());
  }
}

// Directions of the body in LPS.
Vec3 side_lps(const std::string& side) {
  if (side == "left") return Vec3::UnitX();
  if (side == "right") return -Vec3::UnitX();
  if (side == "posterior") return Vec3::UnitY();
  if (side == "anterior") return -Vec3::UnitY();
  return side == "superior" ? Vec3(Vec3::UnitZ()) : Vec3(-Vec3::UnitZ());
}

atlas::Needs needs_of_scene(const PlayArguments& arguments) {
  if (arguments.scene == "palpation") return {.fields = {Structure::Heart}, .surfaces = {}};
  atlas::Needs needs =
      atlas::everything_in(atlas::Atlas::open(arguments.package, atlas::Needs{}).manifest());
  needs.fields.insert(Structure::Heart);
  return needs;
}

std::unique_ptr<device::Device> make_device(const PlayArguments& arguments,
                                            const field::FieldQuery& field,
                                            const atlas::Manifest& manifest, double& seconds) {
  const device::Pace pace = arguments.fast ? device::Pace::Fast : device::Pace::RealTime;
  if (arguments.device == "replay") {
    std::ifstream stream = open_text(arguments.recording);
    auto replay = std::make_unique<device::ReplayDevice>(
        device::read_recording(stream, arguments.recording),
        device::ReplayOptions{.rate_hz = 1000, .pace = pace});
    seconds = replay->seconds();
    return replay;
  }
  seconds = arguments.seconds;
  const double end_diastole_s = manifest.rr_interval_s * manifest.end_diastole / field.phases();
  const Vec3 outward = manifest.workspace_from_lps.linear() * side_lps(arguments.side);
  device::SimulatedOptions options;
  options.path.anchor_m = 1e-3 * surface_point_mm(field, outward, end_diastole_s);
  options.path.direction = -outward;
  options.path.offset_m = 1e-3 * arguments.depth_mm;
  if (arguments.hand == "palpation") {
    options.path.amplitude_m = 1e-3 * arguments.amplitude_mm;
    options.path.frequency_hz = arguments.frequency_hz;
  }
  options.hand.mass_kg = arguments.mass_kg;
  options.seconds = seconds;
  options.pace = pace;
  return std::make_unique<device::SimulatedDevice>(options);
}

void run_headless(const PlayArguments& arguments, std::ostream& out) {
  if (arguments.package.empty()) throw_usage("name a package; see beatlas-play --help");
  if (!arguments.headless) {
    throw_usage(
        "this build has no viewer; use --headless to feel the package without a picture, or "
        "`beatlas-play probe`");
  }
  if ((arguments.device == "replay") == arguments.recording.empty()) {
    throw_usage("--device replay and --recording FILE belong together; give both or neither");
  }
  const atlas::Atlas atlas = atlas::Atlas::open(arguments.package, needs_of_scene(arguments));
  const atlas::Manifest& manifest = atlas.manifest();
  const auto field = std::make_shared<const field::FieldQuery>(atlas.field(Structure::Heart),
                                                               manifest.rr_interval_s);
  haptics::TwoStepOptions model;
  model.stiffness_n_per_m = manifest.stiffness_n_per_m;
  if (arguments.published) model.time_mode = haptics::TimeMode::Published;
  if (arguments.held) {
    model.held_time_s = manifest.rr_interval_s * manifest.end_diastole / field->phases();
  }
  haptics::Servo servo(field, model, haptics::SafetyOptions{});
  double seconds = 0;
  const auto device = make_device(arguments, *field, manifest, seconds);
  if (!(seconds <= 36000)) throw_invalid("a session longer than 10 hours is not played");
  const auto ticks = static_cast<std::size_t>(seconds * 1000) + 2;
  const Session session = run_session(*device, servo, ticks, !arguments.trace.empty());
  if (!arguments.trace.empty()) write_file(arguments.trace, trace_csv(session.trace));
  if (arguments.json) {
    nlohmann::json json = session_json(session.report);
    json["scene"] = arguments.scene;
    json["time_mode"] = arguments.published ? "published" : "continuous";
    json["heart"] = arguments.held ? "held" : "beating";
    json["pace"] = arguments.fast ? "fast" : "real_time";
    json["stiffness_n_per_m"] = model.stiffness_n_per_m;
    out << json.dump(2) << '\n';
  } else {
    out << session_text(session.report);
  }
}

void add_probe(CLI::App& probe, ProbeArguments& arguments) {
  probe.add_option("PACKAGE", arguments.package, "a .beatlas file")->required();
  probe
      .add_option("--points", arguments.points,
                  "CSV with columns x_mm, y_mm, z_mm, t_s; - for standard input")
      ->required();
  probe.add_option("-o,--output", arguments.output, "CSV to write (default: standard output)");
  probe.add_option("--structure", arguments.structure, "whose surface")->capture_default_str();
  probe.add_option("--frame", arguments.frame, "axes of points, normals and forces")
      ->check(CLI::IsMember({"workspace", "lps"}))
      ->capture_default_str();
}

void add_play(CLI::App& app, PlayArguments& arguments) {
  app.add_option("PACKAGE", arguments.package, "a .beatlas file");
  app.add_flag("--headless", arguments.headless, "no picture: run the servo and report");
  app.add_option("--scene", arguments.scene,
                 "what to load: palpation (the heart's field) or full (every payload)")
      ->check(CLI::IsMember({"palpation", "full"}))
      ->capture_default_str();
  app.add_option("--device", arguments.device, "what moves the user point")
      ->check(CLI::IsMember({"simulated", "replay"}))
      ->capture_default_str();
  app.add_option("--recording", arguments.recording,
                 "replay: CSV with columns t_s, x_mm, y_mm, z_mm (workspace)");
  app.add_option("--seconds", arguments.seconds, "simulated: how long [s]")
      ->check(CLI::Range(0.001, 36000.0))
      ->capture_default_str();
  app.add_option("--hand", arguments.hand, "simulated: a still hand or sinusoidal palpation")
      ->check(CLI::IsMember({"still", "palpation"}))
      ->capture_default_str();
  app.add_option("--side", arguments.side, "simulated: side of the body that is pressed")
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
  app.add_flag("--fast", arguments.fast, "do not wait for the clock");
  app.add_flag("--published", arguments.published,
               "force at the stored frames, interpolated linearly (Nakao et al. 2001)");
  app.add_flag("--held", arguments.held, "the heart stands still at end-diastole");
  app.add_option("--trace", arguments.trace, "CSV of every tick to write");
  app.add_flag("--json", arguments.json, "report as JSON");
}

}  // namespace

int play(int argc, const char* const* argv, std::istream& in, std::ostream& out,
         std::ostream& err) {
  CLI::App app(
      "Feel a beating-heart atlas.\n"
      "  beatlas-play PACKAGE --headless [OPTIONS]\n"
      "  beatlas-play probe PACKAGE --points P.csv [-o OUT.csv]",
      "beatlas-play");
  PlayArguments play_arguments;
  add_play(app, play_arguments);
  ProbeArguments probe_arguments;
  CLI::App* probe_command = app.add_subcommand(
      "probe", "distance, normal, velocity and force at points and times of a CSV");
  add_probe(*probe_command, probe_arguments);
  try {
    app.parse(argc, argv);
    if (probe_command->parsed()) {
      run_probe(probe_arguments, in, out);
    } else {
      run_headless(play_arguments, out);
    }
    out.flush();
    if (!out) throw Error(ErrorCode::Machine, "standard output cannot be written");
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      app.exit(error, out, err);
      return 0;
    }
    err << "beatlas-play: " << error.what() << "; see beatlas-play --help\n";
    return static_cast<int>(ErrorCode::Usage);
  } catch (const Error& error) {
    err << "beatlas-play: " << error.what() << '\n';
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    err << "beatlas-play: there is not enough memory\n";
    return static_cast<int>(ErrorCode::Machine);
  } catch (const std::exception& error) {
    err << "beatlas-play: " << error.what() << '\n';
    return static_cast<int>(ErrorCode::Machine);
  }
}

}  // namespace beatlas::app
