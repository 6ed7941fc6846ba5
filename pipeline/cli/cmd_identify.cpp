#include <algorithm>
#include <fstream>
#include <sstream>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/console.h"
#include "pipeline/identify/identify.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"
#include "runtime/base/replace_file.h"
#include "runtime/device/csv_table.h"
#include "runtime/palpation/units.h"
#include "runtime/plot/plot.h"

namespace beatlas::cli {
namespace {

using identify::Estimate;
using identify::Recording;
using nlohmann::json;

constexpr double kMPerMm = 1e-3;

struct IdentifyArguments {
  std::vector<std::string> recordings;
  std::string output;
  std::string plot;
  std::string place = "middle";
  double area_cm2 = 1.2;
  bool as_json = false;
};

struct Outcome {
  json parameters = json::object();  // of one place
  json estimates = json::object();
  std::string text;
  std::vector<plot::Plot> plots;
};

// A recording tells by its columns what it is of: stretch_mm a relaxation, dent_mm a press.
Recording read_recording(const std::string& file, double area_cm2, bool& relaxation) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw_invalid(file + " cannot be read; check its name and rights");
  const std::vector<std::string> columns = device::read_csv(stream, file, {}).columns;
  const auto has = [&](const char* name) {
    return std::find(columns.begin(), columns.end(), name) != columns.end();
  };
  relaxation = has("stretch_mm");
  if (!relaxation && !has("dent_mm")) {
    throw_invalid(file + " has neither a column stretch_mm (a relaxation) nor dent_mm (a press)");
  }
  const bool pressure = relaxation && !has("force_n") && has("lv_mmhg");
  stream.clear();
  stream.seekg(0);
  const device::CsvTable table = device::read_csv(
      stream, file,
      {"t_s", relaxation ? "stretch_mm" : "dent_mm", pressure ? "lv_mmhg" : "force_n"});
  const double scale = pressure ? palpation::kPaPerMmhg * palpation::kM2PerCm2 * area_cm2 : 1;
  Recording out;
  for (const std::vector<double>& row : table.rows) {
    out.time_s.push_back(row[0]);
    out.position_m.push_back(kMPerMm * row[1]);
    out.force_n.push_back(scale * row[2]);
  }
  return out;
}

std::vector<double> scaled(const std::vector<double>& values, double by) {
  std::vector<double> out;
  out.reserve(values.size());
  for (const double value : values) out.push_back(by * value);
  return out;
}

void add(Outcome& outcome, const std::string& key, const Estimate& estimate) {
  outcome.parameters[key] = estimate.value;
  outcome.estimates[key] = {{"value", estimate.value},
                            {"low", estimate.low},
                            {"high", estimate.high},
                            {"open_low", estimate.open_low},
                            {"open_high", estimate.open_high}};
  std::ostringstream line;
  line.precision(4);
  line << key << ": " << estimate.value << " (95 %: " << estimate.low << " to " << estimate.high
       << (estimate.open_low || estimate.open_high ? ", not bounded by the recording" : "")
       << ")\n";
  outcome.text += line.str();
}

plot::Plot fit_plot(const std::string& title, const std::string& y_title,
                    const std::vector<double>& time_s, const std::vector<double>& recorded,
                    const std::vector<double>& fitted) {
  return {.title = title,
          .x_title = "time [s]",
          .y_title = y_title,
          .series = {{.name = "recorded", .x = time_s, .y = recorded},
                     {.name = "fitted", .x = time_s, .y = fitted}}};
}

void take(Outcome& outcome, const Recording& recording, bool relaxation) {
  if (relaxation) {
    const identify::HorizontalFit fit = identify::identify_horizontal(recording);
    add(outcome, "k_h1_n_per_m", fit.k_h1_n_per_m);
    add(outcome, "k_h2_n_per_m", fit.k_h2_n_per_m);
    add(outcome, "c_h_n_s_per_m", fit.c_h_n_s_per_m);
    outcome.plots.push_back(fit_plot("Relaxation: force of the muscle", "force [N]",
                                     recording.time_s, recording.force_n, fit.fitted_n));
  } else {
    const identify::VerticalFit fit = identify::identify_vertical(recording);
    add(outcome, "k_v_n_per_m", fit.k_v_n_per_m);
    add(outcome, "c_v_n_s_per_m", fit.c_v_n_s_per_m);
    outcome.plots.push_back(fit_plot("Press and release: dent of the wall", "dent [mm]",
                                     recording.time_s, scaled(recording.position_m, 1e3),
                                     scaled(fit.fitted_m, 1e3)));
  }
}

int run_identify(const IdentifyArguments& arguments) {
  Outcome outcome;
  for (const std::string& file : arguments.recordings) {
    bool relaxation = false;
    const Recording recording = read_recording(file, arguments.area_cm2, relaxation);
    if (outcome.parameters.contains(relaxation ? "k_h1_n_per_m" : "k_v_n_per_m")) {
      throw_invalid(file + " is a second " + (relaxation ? "relaxation" : "press") +
                    "; give one of each");
    }
    try {
      take(outcome, recording, relaxation);
    } catch (const Error& error) {
      throw error.with_context(file);
    }
  }
  const json parameters = {{"version", 1}, {"muscle", {{arguments.place, outcome.parameters}}}};
  const std::string output = parameters.dump(2) + "\n";
  const std::string plot = plot::plots_svg(outcome.plots);
  if (!arguments.output.empty()) refuse_other_kind(arguments.output, output);
  if (!arguments.plot.empty()) refuse_other_kind(arguments.plot, plot);
  if (!arguments.output.empty()) study::write_text(arguments.output, output);
  if (!arguments.plot.empty()) study::write_text(arguments.plot, plot);
  if (arguments.as_json) {
    print_data(json{{"place", arguments.place}, {"estimates", outcome.estimates}}.dump(2) + "\n");
  } else {
    print_data(outcome.text);
  }
  return 0;
}

}  // namespace

void add_identify(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<IdentifyArguments>();
  CLI::App* command = app.add_subcommand(
      "identify",
      "Constants of muscle from recordings, with 95 % intervals: CSV with t_s, stretch_mm and "
      "force_n (or lv_mmhg) of a relaxation, with t_s, dent_mm and force_n of a press");
  command->add_option("RECORDING", arguments->recordings, "A relaxation, a press, or one of each")
      ->required()
      ->expected(1, 2);
  command->add_option("-o,--output", arguments->output, "Write parameters for beatlas-play here")
      ->type_name("P.json");
  command->add_option("--plot", arguments->plot, "Write recording and fit here")
      ->type_name("FIT.svg");
  command->add_option("--place", arguments->place, "Where in the wall it was recorded")
      ->check(CLI::IsMember({"base", "middle", "apex"}))
      ->capture_default_str();
  command->add_option("--area-cm2", arguments->area_cm2, "lv_mmhg: the area it acts on")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  command->add_flag("--json", arguments->as_json, "Estimates as JSON");
  command->callback([arguments, &run] { run = [arguments] { return run_identify(*arguments); }; });
}

}  // namespace beatlas::cli
