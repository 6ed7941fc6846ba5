#include "pipeline/cli/phantom_words.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <CLI/CLI.hpp>

#include "pipeline/phantom/signals.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace {

using phantom::PhantomSpec;
using phantom::ScannerSpec;

constexpr int kMostSeed = std::numeric_limits<int>::max();

struct Adder {
  CLI::App& command;
  std::shared_ptr<PhantomWords> words;
  std::string group;

  /// An option whose value, where given, goes to `set`.
  template <class T, class Set>
  CLI::Option* add(const std::string& name, const std::string& help, Set set) const {
    const auto value = std::make_shared<T>();
    CLI::Option* option = command.add_option(name, *value, help)->group(group);
    words->changes.push_back([option, value, set](PhantomSpec& spec) {
      if (option->count() > 0) set(spec, *value);
    });
    return option;
  }

  /// Of the scanner's number `key`, with its range.
  void number(const std::string& name, const std::string& key, const std::string& help) const {
    for (const auto& each : phantom::scanner_numbers()) {
      if (key != each.key) continue;
      add<double>(name, help, [member = each.member](PhantomSpec& spec, double value) {
        spec.scanner.*member = value;
      })->check(CLI::Range(each.low, each.high));
    }
    for (const auto& each : phantom::scanner_whole_numbers()) {
      if (key != each.key) continue;
      add<int>(name, help, [member = each.member](PhantomSpec& spec, int value) {
        spec.scanner.*member = value;
      })->check(CLI::Range(each.low, each.high));
    }
  }
};

/// Three numbers written X,Y,Z within a range.
template <class T, class Set>
void add_three(const Adder& adder, const std::string& name, const std::string& help, T low, T high,
               Set set) {
  adder
      .add<std::vector<T>>(name, help,
                           [set](PhantomSpec& spec, const std::vector<T>& v) { set(spec, v); })
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z")
      ->check(CLI::Range(low, high));
}

void add_heart(Adder adder) {
  adder.group = "Heart";
  adder
      .add<double>("--scale", "Factor of every length of the heart; preset's: 1",
                   [](PhantomSpec& spec, double value) { spec.anatomy.scale = value; })
      ->check(CLI::Range(0.3, 1.6));
  adder
      .add<std::vector<std::string>>(
          "--without",
          "Bodies to leave out: atria, aorta, papillary_muscles, pericardial_fat, or all of them",
          [](PhantomSpec& spec, const std::vector<std::string>& bodies) {
            for (const std::string& body : bodies) phantom::leave_out(spec.anatomy, body);
          })
      ->delimiter(',')
      ->type_name("BODY,...")
      ->check(CLI::IsMember(phantom::bodies_to_leave_out()));
  adder
      .add<bool>("--infarct", "Whether a segment of the LV is thin and still; preset's: infarct's",
                 [](PhantomSpec& spec, bool value) { spec.anatomy.infarct.present = value; })
      ->type_name("true|false");
  adder
      .add<double>("--torsion",
                   "Turn of the apex against the base until end systole [degrees]; preset's: 0",
                   [](PhantomSpec& spec, double value) { spec.anatomy.torsion_deg = value; })
      ->check(CLI::Range(-45.0, 45.0));
  adder
      .add<double>("--liver-rise",
                   "How far the liver is raised toward the heart [mm]; 20 brings them in touch",
                   [](PhantomSpec& spec, double value) { spec.anatomy.liver_rise_mm = value; })
      ->check(CLI::Range(0.0, 60.0));
  adder
      .add<double>("--rr", "R-R interval [s]",
                   [](PhantomSpec& spec, double value) { spec.rr_interval_s = value; })
      ->check(CLI::Range(0.2, 3.0));
}

void add_matrix(Adder adder) {
  adder.group = "Images";
  adder
      .add<int>("--phases", "Frames, uniform in the R-R interval",
                [](PhantomSpec& spec, int value) { spec.phases = value; })
      ->check(CLI::Range(2, 200));
  // One change for both, as either alone keeps the field of view.
  struct Matrix {
    std::vector<int> size;
    std::vector<double> spacing_mm;
  };
  const auto matrix = std::make_shared<Matrix>();
  adder.command
      .add_option("--matrix", matrix->size,
                  "Columns, rows and slices; without --spacing the field of view is kept")
      ->group(adder.group)
      ->delimiter(',')
      ->expected(3)
      ->type_name("I,J,K")
      ->check(CLI::Range(1, 1024));
  adder.command
      .add_option(
          "--spacing", matrix->spacing_mm,
          "Distance of columns, rows and slices [mm]; without --matrix the field of view is "
          "kept")
      ->group(adder.group)
      ->delimiter(',')
      ->expected(3)
      ->type_name("I,J,K")
      ->check(CLI::Range(0.2, 30.0));
  adder.words->changes.push_back([matrix](PhantomSpec& spec) {
    const auto& n = matrix->size;
    const auto& mm = matrix->spacing_mm;
    if (n.empty() && mm.empty()) return;
    spec.grid =
        phantom::on_matrix(spec.grid, n.empty() ? Index3{0, 0, 0} : Index3{n[0], n[1], n[2]},
                           mm.empty() ? Vec3(Vec3::Zero()) : Vec3(mm[0], mm[1], mm[2]));
  });
  add_three<double>(adder, "--oblique",
                    "Turn the images about their centre: about x, then y, then z [degrees, LPS]; "
                    "preset's: 0,0,0",
                    -180.0, 180.0, [](PhantomSpec& spec, const std::vector<double>& v) {
                      spec.oblique_deg = {v[0], v[1], v[2]};
                    });
  adder
      .add<std::string>(
          "--signals", "Signals of the tissues: A low contrast, B literature-like; preset's: B",
          [](PhantomSpec& spec, const std::string& value) { spec.scanner.signals = value; })
      ->check(CLI::IsMember(phantom::signals_names()));
}

void add_voxels(Adder adder) {
  adder.group = "Scanner: voxels";
  adder
      .add<std::string>("--partial-volume",
                        "How a voxel averages its box: exact shares, 4 x 4 x 4 points "
                        "(supersampled), or its centre alone (none); default exact",
                        [](PhantomSpec& spec, const std::string& value) {
                          spec.scanner.partial_volume = phantom::partial_volume_from_name(value);
                        })
      ->check(CLI::IsMember(phantom::partial_volume_names()));
  adder.number("--slice-thickness", "slice_thickness_mm",
               "What a slice averages over [mm]; 0 = the distance of slices");
  adder.number("--in-plane-blur", "in_plane_sigma_mm",
               "Standard deviation of a Gaussian blur within the slice [mm]; 0 = off");
  adder.number("--slice-tails", "slice_sigma_mm",
               "Standard deviation of the Gaussian tails of the slice profile [mm]; 0 = off");
}

void add_coil(Adder adder) {
  adder.group = "Scanner: noise and coil";
  adder
      .add<double>("--snr", "Signal of blood over the noise of a channel, 1 or more; 0 = no noise",
                   [](PhantomSpec& spec, double value) {
                     spec.scanner.snr_blood =
                         value == 0.0 ? std::numeric_limits<double>::infinity() : value;
                   })
      ->check(CLI::Validator(
          [](const std::string& text) {
            const double value = std::strtod(text.c_str(), nullptr);
            const bool good = value == 0.0 || (value >= 1.0 && value <= 1e6);
            return good ? std::string()
                        : "Value " + text + " not in range: 0, or from 1 to 1000000";
          },
          "0 or [1 - 1000000]"));
  adder.number("--bias", "bias_share",
               "Bias of the coil's sensitivity: 0.3 = 1 +- 0.3 about the heart; 0 = off");
}

void add_time(Adder adder) {
  adder.group = "Scanner: time";
  adder.number("--gating-window", "gating_window_s",
               "Each frame is the mean over this long [s]; 0 = off");
  adder.number("--subphases", "gating_subphases", "Moments in the gating window; default 5");
  adder.number("--jitter", "jitter_sigma_s",
               "Standard deviation of the trigger of each slice and frame [s]; 0 = off");
  adder.number("--mistriggered", "mistriggered_slices",
               "So many slices show the heart too late; 0 = off");
  adder.number("--mistrigger-by", "mistrigger_s", "How late they do [s]; default 0.02");
}

void add_place(Adder adder) {
  adder.group = "Scanner: place and flow";
  adder.number(
      "--shifts", "shift_sigma_mm",
      "Standard deviation of each slice's shift, along rows and along columns [mm]; 0 = off");
  adder.number("--shift-limit", "shift_limit_mm", "The longest shift [mm]; default 5");
  adder.number("--flow-void", "flow_void_share",
               "Share of blood's signal lost in the jet at peak ejection; 0 = off, usual 0.5");
  const auto with_arms = std::make_shared<bool>(false);
  CLI::Option* arms =
      adder.command
          .add_flag("--arms,!--no-arms", *with_arms, "Arms beside the chest that fold over")
          ->group(adder.group);
  adder.words->changes.push_back([arms, with_arms](PhantomSpec& spec) {
    if (arms->count() > 0) spec.scanner.arms = *with_arms;
  });
  adder
      .add<std::string>(
          "--phase-encoding", "Axis they fold over along: i columns, j rows; default i",
          [](PhantomSpec& spec, const std::string& value) { spec.scanner.phase_encoding = value; })
      ->check(CLI::IsMember({"i", "j"}));
}

void add_seeds(Adder adder) {
  adder.group = "Seeds";
  adder
      .add<int>("--seed", "Of everything drawn at random; the preset's are 1",
                [](PhantomSpec& spec, int value) {
                  ScannerSpec& scanner = spec.scanner;
                  scanner.noise_seed = scanner.bias_seed = value;
                  scanner.trigger_seed = scanner.shift_seed = value;
                })
      ->check(CLI::Range(0, kMostSeed));
  adder.number("--noise-seed", "noise_seed", "Of the noise alone");
  adder.number("--bias-seed", "bias_seed", "Of where the coil lies");
  adder.number("--trigger-seed", "trigger_seed", "Of jitter and mis-triggered slices");
  adder.number("--shift-seed", "shift_seed", "Of the slices' shifts");
}

}  // namespace

void add_phantom_words(CLI::App& command, const std::shared_ptr<PhantomWords>& words) {
  CLI::Option* preset =
      command.add_option("--preset", words->preset, "Heart and scanner to start from")
          ->check(CLI::IsMember(phantom::preset_names()))
          ->capture_default_str();
  command
      .add_option("--spec", words->spec_file,
                  "A whole spec to start from instead, as under \"spec\" in truth.json")
      ->type_name("FILE.json")
      ->excludes(preset);
  const Adder adder{command, words, ""};
  add_heart(adder);
  add_matrix(adder);
  add_voxels(adder);
  add_coil(adder);
  add_time(adder);
  add_place(adder);
  add_seeds(adder);
}

PhantomSpec phantom_spec(const PhantomWords& words) {
  PhantomSpec spec;
  if (words.spec_file.empty()) {
    spec = phantom::preset(words.preset);
  } else {
    const nlohmann::json spec_json = study::read_json(words.spec_file);
    try {
      spec = phantom::spec_from_json(spec_json);
    } catch (const Error& error) {
      throw error.with_context(words.spec_file);
    }
  }
  for (const auto& change : words.changes) change(spec);
  phantom::check_spec(spec);
  return spec;
}

}  // namespace beatlas::cli
