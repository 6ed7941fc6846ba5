#include "runtime/viewer/command.h"

#include <QGuiApplication>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "runtime/app/case_command.h"
#include "runtime/app/exercise_session.h"
#include "runtime/app/fingers.h"
#include "runtime/base/error.h"
#include "runtime/haptics/pericardial_field.h"
#include "runtime/viewer/device_choice.h"
#include "runtime/viewer/display.h"
#include "runtime/viewer/stills.h"
#include "runtime/viewer/window.h"

namespace beatlas::viewer {
namespace {

struct Words {
  ViewOptions options;
  std::string package;
  std::string phase = "ed";
  std::string screenshot;
  std::string record;
  int frames = 30;
  std::string cut;
  std::vector<double> cut_plane;
  std::string volume = "off";
  std::string colour = "structure";
  std::vector<std::string> opacity;
  std::vector<double> press_at;
  std::string size = "800x600";
  std::string recording;
  std::string library;
  std::string haply_host = "localhost";
  int haply_port = 10001;
  std::string lever_line;
  std::string fingers;
  std::string parameters;
  std::string case_file;
  app::PlayArguments exercise;
};

[[noreturn]] void throw_usage(const std::string& message) {
  throw Error(ErrorCode::Usage, message);
}

template <class Names>
std::vector<std::string> words_of(const Names& names) {
  return {names.begin(), names.end()};
}

void add_options(CLI::App& app, Words& words) {
  ViewOptions& options = words.options;
  app.add_option("PACKAGE", words.package, "a .beatlas file");
  app.add_option("--screenshot", words.screenshot, "PNG to write instead of opening a window");
  app.add_option("--record", words.record, "folder for the pictures of one beat, frame_NNNN.png");
  app.add_option("--frames", words.frames, "record: how many")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app.add_option("--phase", words.phase, "ed, es, or a part of the beat from 0 to 1")
      ->capture_default_str();
  app.add_option("--view", options.view, "from where (anterior; left with --press-mm)")
      ->check(CLI::IsMember(words_of(kViews)));
  app.add_option("--zoom", options.zoom, "larger than all that beats")
      ->check(CLI::Range(0.05, 50.0))
      ->capture_default_str();
  app.add_option("--cut", words.cut, "take one half away, with the image on the cut")
      ->check(CLI::IsMember(words_of(kCuts)));
  app.add_option("--cut-offset-mm", options.cut_offset_mm, "cut: away from the middle")
      ->check(CLI::Range(-300.0, 300.0));
  app.add_option("--cut-plane", words.cut_plane,
                 "a free cut: a point [mm] and a normal, workspace; what is on the normal's side "
                 "is taken away")
      ->expected(6);
  app.add_flag("!--no-image", options.image_on_cut, "cut: structures' colours, not the image");
  app.add_option("--volume", words.volume,
                 "the images as a volume: muscle, or blood (the bright cavities through the beat, "
                 "not measured flow)")
      ->check(CLI::IsMember({"off", "muscle", "blood"}))
      ->capture_default_str();
  app.add_option("--colour,--color", words.colour,
                 "the LV's wall by thickness, stiffness or AHA segments, or every surface by "
                 "uncertainty: how near the true one lies with 90 %; with a legend")
      ->check(CLI::IsMember(words_of(kColourings)))
      ->capture_default_str();
  app.add_option("--preset", options.preset,
                 "the disease that is felt, and whose stiffness is shown")
      ->check(CLI::IsMember(palpation::palpation_presets()))
      ->capture_default_str();
  app.add_option(
         "--model", options.model,
         "the force: proxy, a spring; patch, paper B's muscle as it is at the place that is "
         "touched (for a disease)")
      ->check(CLI::IsMember({"proxy", "patch"}));
  app.add_option("--opacity", words.opacity, "STRUCTURE=0..1, as heart=0.2; 0 hides; repeatable");
  app.add_option("--press-mm,--press", options.press_mm,
                 "a tool presses so deep [mm], eight beats long, until it is --phase")
      ->check(CLI::Range(0.0, 15.0));
  app.add_option("--press-at", words.press_at,
                 "press: direction from the heart's centre, patient LPS (the LV's free wall)")
      ->expected(3);
  app.add_flag("--plots", options.plots, "volumes, or force, depth and P-V loops of the press");
  app.add_flag("!--no-caption", options.caption, "no names, scale bar and orientation cube");
  app.add_flag("--stereo", options.anaglyph, "for glasses with red on the left and cyan");
  app.add_option("--text-scale", options.text_scale, "words so many times as large")
      ->check(CLI::Range(0.5, 4.0))
      ->capture_default_str();
  app.add_option("--size", words.size, "pixels, WIDTHxHEIGHT")->capture_default_str();
}

void add_device_options(CLI::App& app, Words& words) {
  std::vector<std::string> names;
  for (const DeviceChoice& choice : kDevices) names.emplace_back(choice.name);
  app.add_option("--device", words.options.device,
                 "window: what moves the tool; the window's list has them, too")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  app.add_option("--recording", words.recording,
                 "replay: CSV with columns t_s, x_mm, y_mm, z_mm (workspace)");
  app.add_option("--device-library", words.library,
                 "3ds, dhd: the vendor's library, if it is not where the system looks");
  app.add_option("--haply-host", words.haply_host, "where Haply's service runs")
      ->capture_default_str();
  app.add_option("--haply-port", words.haply_port, "its port")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  app.add_option("--lever-line", words.lever_line, "lever: its serial line");
  app.add_option("--fingers", words.fingers,
                 "window: JSON of two to eight devices that touch this heart at once");
  app.add_option("--parameters", words.parameters,
                 "window: JSON of muscle, circulation and disease, instead of a preset");
  app.add_option("--case", words.case_file,
                 "window: JSON of a heart and what was felt on it: its atlas, unless a PACKAGE is "
                 "named, with the muscle as it says");
  app.add_flag("--window", words.exercise.window, "with --exercise: in this window");
  app.add_option("--exercise", words.exercise.exercise,
                 "window: JSON of what is hidden in this heart to be found by touch");
  app.add_option("--session", words.exercise.session,
                 "folder in which the exercise is kept; one that was broken off goes on");
  app.add_option("--seed", words.exercise.seed, "exercise: what is hidden; if not said, by chance")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 53));
  app.add_option("--tool-radius-mm", words.options.tool_radius_mm,
                 "window: of the tool; 0 is 3 mm, in a cavity 1 mm")
      ->check(CLI::Range(0.0, 20.0));
  app.add_option("--inside", words.options.inside,
                 "window: a cavity that the tool is in, whose wall it feels from within")
      ->check(CLI::IsMember(app::cavity_names()));
  app.add_option("--effusion-mm", words.options.effusion_mm,
                 "with --inside pericardium: the fluid's thickness around the heart at its largest")
      ->check(CLI::Range(haptics::PericardialOptions::kThinnestMm,
                         haptics::PericardialOptions::kThickestMm));
  app.add_flag("--valve", words.options.valve,
               "with --inside lv_blood: the tool may come and go through the valve at its base");
}

void read_device(Words& words) {
  ViewOptions& options = words.options;
  if ((options.device == "replay") == words.recording.empty()) {
    throw_usage("--device replay and --recording FILE belong together; give both or neither");
  }
  // With --fingers each file's finger says whether it is a lever.
  if (words.fingers.empty() && (options.device == "lever") == words.lever_line.empty()) {
    throw_usage("--device lever and --lever-line FILE belong together; give both or neither");
  }
  if (options.device == "replay") options.device_detail = words.recording;
  if (options.device == "lever") options.device_detail = words.lever_line;
  if (options.device == "3ds" || options.device == "dhd") options.device_detail = words.library;
  if (options.device == "haply") {
    options.device_detail = words.haply_host + ":" + std::to_string(words.haply_port);
  }
}

device::HardwareOptions hardware_of(const Words& words) {
  device::HardwareOptions out;
  out.library = words.library;
  out.host = words.haply_host;
  out.port = words.haply_port;
  out.line = words.lever_line;
  return out;
}

// What several fingers or a catheter do is seen in the window alone.
void read_touch(Words& words) {
  ViewOptions& options = words.options;
  const bool still = !words.screenshot.empty() || !words.record.empty();
  if (still && !(words.fingers.empty() && options.inside.empty())) {
    throw_usage("--fingers and --inside are of the window; leave --screenshot and --record out");
  }
  app::check_inside(options.inside, options.valve, options.effusion_mm);
  if (!options.inside.empty() && model_of(options) != "proxy") {
    throw_usage("a cavity is felt from inside as a spring; leave --model and --preset out");
  }
  if (options.tool_radius_mm == 0) options.tool_radius_mm = options.inside.empty() ? 3 : 1;
  if (words.fingers.empty()) return;
  if (words.package.empty()) throw_usage("name a package for the fingers; see --help");
  if (options.device != "mouse") {
    throw_usage("--fingers tells what moves each of them; leave --device out");
  }
  app::PlayArguments all;
  all.package = words.package;
  all.hardware = hardware_of(words);
  all.inside = options.inside;
  all.effusion_mm = options.effusion_mm;
  all.tool_radius_mm = options.tool_radius_mm;
  constexpr double kLongestS = 36000;
  all.seconds = kLongestS;
  options.fingers = app::read_fingers(words.fingers, all);
}

// The muscle that a file tells, or a case, which tells its heart as well.
void read_muscle(Words& words) {
  ViewOptions& options = words.options;
  if (words.parameters.empty() && words.case_file.empty()) return;
  if (!words.screenshot.empty() || !words.record.empty()) {
    throw_usage("--parameters and --case are of the window; leave --screenshot and --record out");
  }
  app::PlayArguments asked;
  asked.package = words.package;
  asked.case_file = words.case_file;
  asked.press.parameters = words.parameters;
  if (options.preset != "healthy") asked.press.preset = options.preset;
  asked.model_named = !options.model.empty();
  asked.inside = options.inside;
  asked.exercise = words.exercise.exercise;
  asked = app::take_case(asked);
  if (asked.package.empty()) {
    throw_usage(words.case_file.empty()
                    ? "name a package for the muscle; see --help"
                    : words.case_file + " names no atlas; name a PACKAGE beside --case");
  }
  words.package = asked.package;
  options.told = app::told_muscle(asked.press.parameters, asked.press.preset);
  const std::string& file = words.case_file.empty() ? words.parameters : words.case_file;
  options.told_name = std::filesystem::path(file).filename().string();
  options.heart_rate_per_min = asked.heart_rate_per_min;
}

void read_exercise(Words& words) {
  app::PlayArguments& exercise = words.exercise;
  if (exercise.exercise.empty() != exercise.session.empty() ||
      exercise.exercise.empty() == exercise.window) {
    throw_usage("--window, --exercise FILE and --session FOLDER belong together; give all or none");
  }
  if (exercise.exercise.empty()) {
    if (exercise.seed >= 0) throw_usage("--seed is of an exercise; name one by --exercise");
    return;
  }
  const ViewOptions& options = words.options;
  if (words.package.empty()) throw_usage("name a package for the exercise; see --help");
  if (!words.screenshot.empty() || !words.record.empty() || !words.fingers.empty() ||
      !options.inside.empty()) {
    throw_usage(
        "an exercise is of one finger in a window; leave --screenshot, --record, --fingers and "
        "--inside out");
  }
  if (options.preset != "healthy" || !options.model.empty() || options.told) {
    throw_usage(
        "an exercise tells its own preset; leave --preset, --parameters, --case and --model out");
  }
  exercise.package = words.package;
  exercise.device = options.device;
  exercise.recording = words.recording;
  exercise.hardware = hardware_of(words);
  (void)app::read_exercise(exercise.exercise);  // what is wrong with it is said before a window is
  words.options.exercise = exercise;
}

void read_size(Words& words) {
  const std::size_t by = words.size.find('x');
  const auto number = [](const std::string& text) {
    const bool digits = !text.empty() && text.size() <= 5 &&
                        text.find_first_not_of("0123456789") == std::string::npos;
    return digits ? std::stoi(text) : 0;
  };
  if (by != std::string::npos) {
    words.options.width = number(words.size.substr(0, by));
    words.options.height = number(words.size.substr(by + 1));
  }
  const auto in_range = [](int pixels) { return pixels >= 64 && pixels <= 8192; };
  if (by == std::string::npos || !in_range(words.options.width) ||
      !in_range(words.options.height)) {
    throw_usage("--size must be WIDTHxHEIGHT, each from 64 to 8192, as 800x600");
  }
}

void read_opacity(Words& words) {
  for (const std::string& word : words.opacity) {
    const std::size_t at = word.find('=');
    const auto structure = structure_from_name(word.substr(0, at));
    double opacity = -1;
    std::size_t used = 0;
    try {
      if (at != std::string::npos) opacity = std::stod(word.substr(at + 1), &used);
    } catch (const std::exception&) {
      opacity = -1;
    }
    if (!structure || !(opacity >= 0 && opacity <= 1) || at + 1 + used != word.size()) {
      throw_usage("--opacity must be STRUCTURE=0..1, as heart=0.2, not " + word);
    }
    words.options.opacity[*structure] = opacity;
  }
}

void read_words(Words& words) {
  ViewOptions& options = words.options;
  read_muscle(words);
  options.package = words.package;
  if (options.view.empty()) options.view = options.press_mm > 0 ? "left" : "anterior";
  options.cut = words.cut;
  if (words.volume == "muscle") options.volume = VolumePreset::Muscle;
  if (words.volume == "blood") options.volume = VolumePreset::Blood;
  options.colour = colouring_of(words.colour);
  read_size(words);
  read_device(words);
  read_opacity(words);
  read_touch(words);
  read_exercise(words);
  if (!words.cut_plane.empty()) {
    const std::vector<double>& v = words.cut_plane;
    if (!words.cut.empty()) throw_usage("--cut and --cut-plane both cut; give one of them");
    const Vec3 normal(v[3], v[4], v[5]);
    if (!(normal.norm() > 1e-6) || !normal.allFinite()) {
      throw_usage("--cut-plane: the normal has no direction");
    }
    options.free_cut = CutPlane{.point_mm = {v[0], v[1], v[2]}, .normal = normal.normalized()};
  }
  if (!words.press_at.empty()) {
    const Vec3 direction(words.press_at[0], words.press_at[1], words.press_at[2]);
    if (!(direction.norm() > 1e-6)) throw_usage("--press-at is no direction");
    options.press_lps = direction;
  }
  if (!words.screenshot.empty() && !words.record.empty()) {
    throw_usage("--screenshot and --record exclude each other; give one of them");
  }
  std::string ending = std::filesystem::path(words.screenshot).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (!words.screenshot.empty() && ending != ".png") {
    throw_usage("--screenshot writes PNG; name a file that ends in .png");
  }
  if (words.package.empty() && (!words.screenshot.empty() || !words.record.empty())) {
    throw_usage("name a package; see --help");
  }
}

// What is to be seen has to be there; what is to be hidden need not.
void check_opacity(const ViewOptions& options, const atlas::Atlas& heart) {
  std::string there;
  for (const Structure structure : kAllStructures) {
    if (!heart.surface(structure)) continue;
    there += (there.empty() ? "" : ", ") + std::string(structure_name(structure));
  }
  for (const auto& [structure, opacity] : options.opacity) {
    if (opacity == 0 || heart.surface(structure)) continue;
    throw_invalid("--opacity: " + options.package.string() + " has no surface of " +
                  std::string(structure_name(structure)) + "; it has " + there);
  }
}

void write_stills(Words& words) {
  const OpenedHeart heart = open_heart(words.options.package);
  check_opacity(words.options, *heart.atlas);
  words.options.phase = phase_of(words.phase, heart.atlas->manifest());
  const Display display;
  const LostDisplayWatch watch("beatlas-play", {});
  qInstallMessageHandler([](QtMsgType, const QMessageLogContext&, const QString&) {});
  // Plots need Qt's fonts, no window.
  setenv("QT_QPA_PLATFORM", "offscreen", 1);
  int count = 1;
  std::string name = "beatlas-view";
  char* names[] = {name.data(), nullptr};
  const QGuiApplication application(count, names);
  if (!words.screenshot.empty()) {
    write_screenshot(words.options, heart, words.screenshot);
  } else {
    write_recording(words.options, heart, words.record, words.frames);
  }
}

int run(Words& words) {
  read_words(words);
  if (!words.screenshot.empty() || !words.record.empty()) {
    write_stills(words);
    return 0;
  }
  // What is wrong with the package is said before there is a window.
  std::optional<OpenedHeart> heart;
  if (!words.package.empty()) {
    heart = open_heart(words.options.package, words.options.inside, words.options.valve);
    check_opacity(words.options, *heart->atlas);
    words.options.phase = phase_of(words.phase, heart->atlas->manifest());
  }
  if (!has_display()) {
    throw Error(ErrorCode::Machine,
                "there is no display for a window; use --screenshot FILE, or --headless");
  }
  return show_window(words.options, heart);
}

}  // namespace

int view(int argc, char** argv, std::ostream& out, std::ostream& err) {
  CLI::App app(
      "See a beating-heart atlas, and touch it with the mouse.\n"
      "  beatlas-play [PACKAGE] [OPTIONS]                     a window\n"
      "  beatlas-play PACKAGE --screenshot FILE.png [OPTIONS]\n"
      "  beatlas-play PACKAGE --record FOLDER [OPTIONS]\n"
      "Pictures need no display: without one an Xvfb is started for them.",
      "beatlas-play");
  Words words;
  add_options(app, words);
  add_device_options(app, words);
  try {
    app.parse(argc, argv);
    return run(words);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      app.exit(error, out, err);
      return 0;
    }
    err << "beatlas-play: " << error.what() << "; see beatlas-view --help\n";
    return static_cast<int>(ErrorCode::Usage);
  } catch (...) {
    return tell_failure(err, "beatlas-play");
  }
}

}  // namespace beatlas::viewer
