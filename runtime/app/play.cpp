#include "runtime/app/play.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <istream>
#include <memory>
#include <ostream>
#include <sstream>
#include <stop_token>
#include <string>

#include <CLI/CLI.hpp>

#include "runtime/app/case_command.h"
#include "runtime/app/exercise_session.h"
#include "runtime/app/fingers.h"
#include "runtime/app/headless.h"
#include "runtime/app/play_device.h"
#include "runtime/app/play_options.h"
#include "runtime/app/press_session.h"
#include "runtime/app/probe_command.h"
#include "runtime/app/sensitivity.h"
#include "runtime/app/text.h"
#include "runtime/app/ticks.h"
#include "runtime/app/touched_heart.h"
#include "runtime/app/ventricle.h"
#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"
#include "runtime/base/interrupts.h"
#include "runtime/base/json_text.h"
#include "runtime/base/replace_file.h"
#include "runtime/device/hardware.h"

namespace beatlas::app {
namespace {

constexpr std::size_t kRecordedTicks = 10000;  // 10 s at 1 kHz, 5 MB

struct SensitivityArguments {
  std::string folder;
  std::string parameters;
  std::string preset;
  bool json = false;
};

struct ReplayArguments {
  std::string package;
  std::string file;  ///< or folder
};

[[noreturn]] void throw_usage(const std::string& message) {
  throw Error(ErrorCode::Usage, message);
}

void check_usage(const PlayArguments& arguments) {
  if (arguments.package.empty() && !arguments.case_file.empty()) {
    throw_usage(arguments.case_file +
                " names no atlas; name a PACKAGE beside --case, or press paper B's ventricle with "
                "--press FOLDER");
  }
  if (arguments.package.empty()) throw_usage("name a package; see beatlas-play --help");
  if (!arguments.headless && arguments.exercise.empty()) {
    throw_usage(
        "this build has no viewer; use --headless to feel the package without a picture, or "
        "`beatlas-play probe`");
  }
  if ((arguments.device == "replay") == arguments.recording.empty()) {
    throw_usage("--device replay and --recording FILE belong together; give both or neither");
  }
  if (arguments.exercise.empty() &&
      (!arguments.session.empty() || arguments.seed >= 0 || arguments.device == "trainee")) {
    throw_usage(
        "--session, --seed and --device trainee are of an exercise; name one by --exercise");
  }
  if (arguments.window) throw_usage("--window is of an exercise; leave --headless out");
  const PressArguments& press = arguments.press;
  if (!arguments.exercise.empty() && !(press.parameters.empty() && press.preset.empty())) {
    throw_usage("an exercise tells its own preset; leave --parameters and --preset out");
  }
  if (!arguments.exercise.empty() && (!arguments.trace.empty() || !arguments.ticks.empty() ||
                                      arguments.held || arguments.published)) {
    throw_usage(
        "an exercise keeps every tick in its folder, of a beating heart; leave --trace, --ticks, "
        "--held and --published out");
  }
  if (!is_patch(arguments) && !(press.parameters.empty() && press.preset.empty())) {
    throw_usage("--parameters and --preset are of paper B's muscle; use them with --model patch");
  }
  if (!arguments.inside.empty() &&
      (arguments.published || !arguments.exercise.empty() ||
       (arguments.model != "proxy" && arguments.model != "fingertip"))) {
    throw_usage(
        "a cavity is felt from inside with --model proxy or fingertip, and not in an exercise; "
        "leave --inside or the other out");
  }
  check_inside(arguments.inside, arguments.valve, arguments.effusion_mm);
  if (!arguments.fingers.empty() &&
      !(arguments.exercise.empty() && arguments.ticks.empty() && arguments.recording.empty())) {
    throw_usage(
        "each finger tells its own recording; leave --exercise, --ticks and --recording out");
  }
  if (arguments.fast && is_hardware(arguments.device) && arguments.device != "trainee") {
    throw_usage("--fast is for simulated, replay and trainee; a real device keeps its own time");
  }
}

// Paper B's own ventricle needs no package: `--headless --scene palpation` alone presses it.
bool is_press(const PlayArguments& arguments) {
  const PressArguments& press = arguments.press;
  return !press.folder.empty() ||
         (arguments.package.empty() && arguments.scene_named && arguments.scene == "palpation");
}

void run_scripted_press(const PlayArguments& arguments, std::ostream& out) {
  if (!arguments.headless) throw_usage("--press has no picture; use it with --headless");
  for (const std::string* other :
       {&arguments.fingers, &arguments.exercise, &arguments.session, &arguments.inside,
        &arguments.trace, &arguments.ticks, &arguments.recording}) {
    if (other->empty()) continue;
    throw_usage(
        "--press plays a script of its own and writes its own files; leave --fingers, --exercise, "
        "--session, --inside, --trace, --ticks and --recording out");
  }
  if (arguments.model_named && !is_patch(arguments)) {
    throw_usage("--press is of paper B's muscle; leave --model out");
  }
  PressArguments press = arguments.press;
  if (press.folder.empty()) press.folder = "palpation";
  press.package = arguments.package;
  press.heart_rate_per_min = arguments.heart_rate_per_min;
  if (press.heart_rate_per_min > 0 &&
      (press.heart_rate_per_min < 30 || press.heart_rate_per_min > 220)) {
    throw_usage("--heart-rate must be from 30 to 220 for a press");
  }
  press.json = arguments.json;
  run_press_session(press, out);
}

void run_headless(const PlayArguments& told, std::ostream& out) {
  const PlayArguments arguments = take_case(told);
  if (is_press(arguments)) return run_scripted_press(arguments, out);
  check_usage(arguments);
  if (!arguments.exercise.empty()) return run_exercise(arguments, out);
  if (!arguments.fingers.empty()) return run_fingers(arguments, out);
  // Before a session rather than after it: what it gave would be lost.
  if (!arguments.trace.empty()) refuse_other_kind(arguments.trace, trace_csv({}));
  if (!arguments.ticks.empty()) refuse_other_kind(arguments.ticks, haptics::kTicksFormat);
  const TouchedHeart heart(arguments);
  const TouchingTool tool = heart.tool(arguments, arguments.ticks.empty() ? 0 : kRecordedTicks);

  SessionOptions options;
  std::stop_source interrupted;
  const Interrupts interrupts([&interrupted] { interrupted.request_stop(); });
  options.stop = interrupted.get_token();
  std::unique_ptr<device::Device> device =
      open_device(arguments, heart.field(), heart.manifest(), options);
  options.keep_trace = !arguments.trace.empty();
  options.watchdog = !arguments.fast;
  std::unique_ptr<TickKeeper> keeper;
  if (!arguments.ticks.empty()) {
    keeper = std::make_unique<TickKeeper>(*tool.servo, arguments.ticks,
                                          ticks_about(heart.manifest(), tool.touch));
  }
  const Session session = run_session(*device, *tool.servo, options);
  device.reset();
  if (keeper) keeper->finish();
  if (!arguments.trace.empty()) write_file(arguments.trace, trace_csv(session.trace));
  if (arguments.json) {
    out << json_text(
               report_json(arguments, tool.touch, heart.rate_per_min(arguments), session.report), 2)
        << '\n';
  } else {
    out << session_text(session.report);
  }
  if (session.lost) throw Error(*session.lost);
  interrupts.check();
  if (session.report.faults > 0) {
    throw Error(ErrorCode::Machine,
                faults_told(session.report) +
                    (arguments.ticks.empty()
                         ? "; --ticks FILE keeps what leads to the first of them"
                         : "; beatlas-play replay-ticks plays what led to the first of them"));
  }
}

/// A subcommand that plays on a package what was kept of it.
CLI::App* add_replay(CLI::App& app, const char* name, const char* what, const char* kept,
                     const char* kept_by, ReplayArguments& arguments) {
  CLI::App* command = app.add_subcommand(name, what);
  command->add_option("PACKAGE", arguments.package, "a .beatlas file")->required();
  command->add_option(kept, arguments.file, kept_by)->required();
  return command;
}

CLI::App* add_replay_ticks(CLI::App& app, ReplayArguments& arguments) {
  CLI::App* command =
      add_replay(app, "replay-ticks",
                 "tick what --ticks kept once more; all must come out the same to the bit", "TICKS",
                 "what --ticks wrote", arguments);
  command->footer("Example:\n  beatlas-play replay-ticks heart.beatlas session.ticks");
  return command;
}

CLI::App* add_replay_exercise(CLI::App& app, ReplayArguments& arguments) {
  CLI::App* command = add_replay(
      app, "replay-exercise",
      "play an exercise's session once more, to the bit, and write its score and report again",
      "FOLDER", "what --session named", arguments);
  command->footer("Example:\n  beatlas-play replay-exercise heart.beatlas session");
  return command;
}

CLI::App* add_sensitivity(CLI::App& app, SensitivityArguments& arguments) {
  CLI::App* command = app.add_subcommand(
      "sensitivity",
      "what each constant of paper B's trainer does to force and loop, at half and twice");
  command->add_option("-o,--output", arguments.folder, "folder for sensitivity.json and .md");
  command->add_option("--parameters", arguments.parameters,
                      "JSON of muscle, circulation and disease");
  command->add_option("--preset", arguments.preset, "of them")
      ->check(CLI::IsMember(palpation::palpation_presets()));
  command->add_flag("--json", arguments.json, "report as JSON");
  command->footer("Example:\n  beatlas-play sensitivity -o out");
  return command;
}

void run_sensitivity(const SensitivityArguments& arguments, std::ostream& out) {
  const ToldMuscle told = told_muscle(arguments.parameters, arguments.preset);
  if (!told.regions.empty()) {
    throw_invalid(arguments.parameters + ": /regions are found on an atlas's wall; leave them out");
  }
  const Sensitivity found = sensitivity_of(told.parameters);
  if (!arguments.folder.empty()) write_sensitivity(found, arguments.folder);
  out << (arguments.json ? json_text(sensitivity_json(found), 2) + "\n"
                         : sensitivity_markdown(found));
}

}  // namespace

int play(int argc, const char* const* argv, std::istream& in, std::ostream& out,
         std::ostream& err) {
  CLI::App app(
      "Feel a beating-heart atlas.\n"
      "  beatlas-play [PACKAGE] [OPTIONS OF THE WINDOW]    see beatlas-view --help\n"
      "  beatlas-play PACKAGE --screenshot FILE|--record FOLDER [...]    as well\n"
      "  beatlas-play PACKAGE --headless [OPTIONS]\n"
      "  beatlas-play [PACKAGE] --headless --scene palpation --press FOLDER [OPTIONS]\n"
      "  beatlas-play probe PACKAGE --points P.csv [-o OUT.csv]\n"
      "  beatlas-play PACKAGE --exercise E.json --session FOLDER [OPTIONS]\n"
      "  beatlas-play replay-ticks PACKAGE TICKS\n"
      "  beatlas-play replay-exercise PACKAGE FOLDER\n"
      "  beatlas-play cases FOLDER [WORDS...]\n"
      "  beatlas-play --case C.case.json --headless [OPTIONS]\n"
      "  beatlas-play sensitivity [-o FOLDER]",
      "beatlas-play");
  PlayArguments play_arguments;
  add_play_options(app, play_arguments);
  app.footer(
      "Example:\n"
      "  beatlas-play heart.beatlas --headless --seconds 5 --tool-radius-mm 3\n"
      "  beatlas-play --headless --scene palpation --press out\n\n"
      "Method:\n"
      "  Force as published: Nakao et al., MEDINFO 2001. Proxy: Zilles and Salisbury, IROS 1995, "
      "and\n  Ruspini et al., SIGGRAPH 1997. The muscle under a finger: Tokuyasu et al., FIMH "
      "2003");
  ProbeArguments probe_arguments;
  const CLI::App* probe_command = add_probe(app, probe_arguments);
  ReplayArguments ticks_arguments;
  const CLI::App* ticks_command = add_replay_ticks(app, ticks_arguments);
  ReplayArguments exercise_arguments;
  const CLI::App* exercise_command = add_replay_exercise(app, exercise_arguments);
  SensitivityArguments sensitivity_arguments;
  const CLI::App* sensitivity_command = add_sensitivity(app, sensitivity_arguments);
  CasesArguments cases_arguments;
  const CLI::App* cases_command = add_cases(app, cases_arguments);
  app.require_subcommand(0, 1);  // behind one, the name of another is a word like any
  try {
    int code = 0;
    app.parse(argc, argv);
    play_arguments.scene_named = app.count("--scene") > 0;
    play_arguments.model_named = app.count("--model") > 0;
    if (probe_command->parsed()) {
      run_probe(probe_arguments, in, out);
    } else if (ticks_command->parsed()) {
      replay_ticks_file(ticks_arguments.package, ticks_arguments.file, out);
    } else if (exercise_command->parsed()) {
      replay_exercise(exercise_arguments.package, exercise_arguments.file, out);
    } else if (sensitivity_command->parsed()) {
      run_sensitivity(sensitivity_arguments, out);
    } else if (cases_command->parsed()) {
      code = run_cases(cases_arguments, out, err);
    } else if (play_arguments.list_devices) {
      out << device::list_devices(play_arguments.hardware);
    } else {
      run_headless(play_arguments, out);
    }
    out.flush();
    if (!out) throw Error(ErrorCode::Machine, "standard output cannot be written");
    return code;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      app.exit(error, out, err);
      return 0;
    }
    err << "beatlas-play: " << error.what() << "; see beatlas-play --help\n";
    return static_cast<int>(ErrorCode::Usage);
  } catch (...) {
    return tell_failure(err, "beatlas-play");
  }
}

}  // namespace beatlas::app
