#include <algorithm>
#include <thread>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "pipeline/assess/bench_plan.h"
#include "pipeline/assess/bench_report.h"
#include "pipeline/build/version.h"
#include "pipeline/cli/bench_probe.h"
#include "pipeline/cli/bench_runner.h"
#include "pipeline/cli/commands.h"
#include "pipeline/core/parallel.h"
#include "pipeline/report/scatter.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
using assess::BenchReport;
using assess::BenchRow;
using assess::Family;
using assess::Sweep;
using nlohmann::json;
namespace {

struct BenchArguments {
  CommonArguments common;
  std::string preset = "small";
  std::string output;
  std::vector<std::string> only;
  bool quick = false;
  bool scaling = false;
  int repeats = 7;
};

/// A folder for packages that goes with the object, whatever ends the command.
class WorkFolder {
 public:
  explicit WorkFolder(const fs::path& beside)
      : path_(beside / (".bench-" + std::to_string(getpid()))) {
    study::make_folder(path_);
  }
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string told(const assess::BenchRun& run) {
  const std::string values = assess::shown_values(run);
  return run.knob + (values.empty() ? "" : " " + values) + " " +
         std::string(assess::sweep_name(run.sweep));
}

/// Runs one after the other, each a stage of the console with the time it took.
void sweep(const BenchArguments& arguments, BenchRunner& runner, const json& defaults,
           Console& console, BenchReport& report) {
  const std::vector<assess::BenchRun> runs =
      assess::plan_runs(assess::bench_knobs(), arguments.only, defaults, arguments.quick);
  for (std::size_t n = 0; n < runs.size(); ++n) {
    const std::string name =
        std::to_string(n + 1) + "/" + std::to_string(runs.size()) + " " + told(runs[n]);
    console.stage(name, [&](StageContext& context) {
      // What stages say of each of many packages is of no use here.
      context.log_sink = {};
      context.warn_sink = {};
      report.rows.push_back(runner.measure(runs[n], context));
    });
  }
  assess::mark_fronts(report.rows);
}

void scale(const BenchArguments& arguments, BenchRunner& runner, const json& defaults,
           Console& console, BenchReport& report) {
  const auto build = [&](const std::string& series, double factor, json settings) {
    const std::string name = series + " x " + json(factor).dump();
    console.stage(name, [&](StageContext& context) {
      context.log_sink = {};
      context.warn_sink = {};
      assess::ScalingRow row = runner.build_all(settings, context);
      row.series = series;
      row.factor = factor;
      if (series == "phases") row.size = settings["phantom"]["phases"].get<double>();
      report.scaling.push_back(std::move(row));
    });
  };
  const std::vector<double> factors =
      arguments.quick ? std::vector<double>{0.125, 1} : std::vector<double>{0.125, 1, 2, 4};
  for (const double factor : factors) {
    json settings = defaults;
    settings["phantom"]["matrix"] = std::cbrt(factor);
    build("voxels", factor, settings);
  }
  const std::vector<int> phases =
      arguments.quick ? std::vector<int>{15, 25} : std::vector<int>{15, 25, 50};
  for (const int count : phases) {
    json settings = defaults;
    settings["phantom"]["phases"] = count;
    build("phases", static_cast<double>(count) / report.phases, settings);
  }
  report.fits = assess::fit_scaling(report.scaling);
}

/// Whether its error is one of distances that are felt.
bool is_plotted(const BenchRow& row) {
  return row.run.family == Family::Field || row.run.family == Family::Published;
}

/// Error against a figure, a series a knob, of one sweep.
report::ScatterPlot plot_of(const BenchReport& bench, Sweep sweep, const std::string& x_title,
                            const std::function<double(const BenchRow&)>& x,
                            const std::function<bool(const BenchRow&)>& front) {
  report::ScatterPlot plot;
  plot.title = sweep == Sweep::Images
                   ? "Speed against error, from images (phantom " + bench.preset + ")"
                   : "Speed against error, from the exact shape (phantom " + bench.preset + ")";
  plot.x_title = x_title;
  plot.y_title = "mean distance error of the heart [mm]";
  plot.front_name = "Pareto front";
  bool default_shown = false;
  for (const BenchRow& row : bench.rows) {
    if (row.run.sweep != sweep || !is_plotted(row)) continue;
    auto series = std::find_if(plot.series.begin(), plot.series.end(),
                               [&](const auto& each) { return each.name == row.run.knob; });
    const bool published = row.run.family == Family::Published;
    if (series == plot.series.end()) {
      plot.series.push_back({row.run.knob, {}, row.run.values.size() == 1});
      series = plot.series.end() - 1;
    }
    // Every knob's default is the same point; it is shown once.
    const bool is_default = row.run.is_default && !published;
    const bool again = is_default && default_shown;
    default_shown = default_shown || is_default;
    series->points.push_back({x(row), row.errors.at(Structure::Heart).mean_mm,
                              published ? "paper A"
                              : again   ? ""
                                        : assess::shown_values(row.run),
                              is_default && !again, front(row)});
  }
  std::erase_if(plot.series, [](const auto& each) { return each.points.empty(); });
  if (plot.series.size() > 8) plot.series.resize(8);
  return plot;
}

void write_plots(const BenchReport& bench, const fs::path& folder) {
  for (const Sweep sweep : {Sweep::Exact, Sweep::Images}) {
    const bool any = std::any_of(bench.rows.begin(), bench.rows.end(), [&](const BenchRow& row) {
      return row.run.sweep == sweep && is_plotted(row);
    });
    if (!any) continue;
    const std::string name = "bench_" + std::string(assess::sweep_name(sweep));
    const auto write = [&](const std::string& what, const report::ScatterPlot& plot) {
      study::write_text(folder / (name + "_" + what + ".svg"), report::scatter_svg(plot));
    };
    write("bytes",
          plot_of(
              bench, sweep, "package of the scene palpation [MB]",
              [](const BenchRow& r) { return 1e-6 * static_cast<double>(r.package_bytes); },
              [](const BenchRow& r) { return r.front_bytes; }));
    write("query", plot_of(
                       bench, sweep, "query along a palpation at 1 kHz [ns]",
                       [](const BenchRow& r) { return r.query_path_ns.value_or(0); },
                       [](const BenchRow& r) { return r.front_query; }));
    write("build", plot_of(
                       bench, sweep, "build of the heart's field [s]",
                       [](const BenchRow& r) { return r.total_s; },
                       [](const BenchRow& r) { return r.front_build; }));
  }
}

int bench(const BenchArguments& arguments) {
  // The ventricles alone: the segmentation does not yet part them from the atria, and would hide
  // what the knobs do.
  phantom::PhantomSpec spec = phantom::preset(arguments.preset);
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  const json defaults = BenchRunner::default_settings(spec);
  // A wrong name is told before the folder is made.
  (void)assess::plan_runs(assess::bench_knobs(), arguments.only, defaults, arguments.quick);
  const fs::path folder(arguments.output);
  study::make_folder(folder);
  study::check_writable(folder / "bench.json");
  set_thread_count(arguments.common.threads);
  Console console(arguments.common.verbose);
  const WorkFolder work(folder);
  BenchRunner runner(spec, defaults, arguments.repeats, work.path());
  BenchReport report;
  report.preset = arguments.preset;
  report.version = build::kVersion;
  report.quick = arguments.quick;
  report.repeats = arguments.repeats;
  report.phases = spec.phases;
  report.threads = arguments.common.threads > 0
                       ? arguments.common.threads
                       : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const double start = wall_clock_s();
  if (arguments.scaling) {
    scale(arguments, runner, defaults, console, report);
  } else {
    sweep(arguments, runner, defaults, console, report);
  }
  report.wall_s = wall_clock_s() - start;
  const std::string name = arguments.scaling ? "scaling" : "bench";
  const std::string tables = assess::bench_to_markdown(report);
  study::write_json(folder / (name + ".json"), assess::bench_to_json(report));
  study::write_text(folder / (name + ".md"), tables);
  if (!arguments.scaling) write_plots(report, folder);
  print_data(tables);
  console.finish();
  return 0;
}

}  // namespace

void add_bench(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<BenchArguments>();
  CLI::App* command =
      app.add_subcommand("bench", "Measure speed against error on a phantom, option by option");
  std::string knobs;
  for (const std::string& name : assess::bench_knob_names()) {
    knobs += (knobs.empty() ? "" : ", ") + name;
  }
  command->footer(
      "Writes bench.json, bench.md and plots (SVG), and prints the tables. With --scaling, "
      "scaling.json\nand scaling.md: time and memory against the voxels of an image and the "
      "phases.\nKnobs: " +
      knobs);
  command->add_option("-o,--output", arguments->output, "Folder for what is measured")
      ->required()
      ->type_name("DIR");
  command->add_option("--preset", arguments->preset, "Phantom to measure on")
      ->check(CLI::IsMember(phantom::preset_names()))
      ->capture_default_str();
  command->add_option("--only", arguments->only, "Knobs to sweep; without: all")
      ->delimiter(',')
      ->type_name("KNOB,...");
  command->add_flag("--quick", arguments->quick, "Two values a knob");
  command->add_flag("--scaling", arguments->scaling,
                    "Whole builds of larger images and more phases instead of the sweep");
  command
      ->add_option("--repeats", arguments->repeats,
                   "Loads and rounds of queries of which the median is taken")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_common(*command, arguments->common);
  command->callback([arguments, &run] { run = [arguments] { return bench(*arguments); }; });
}

}  // namespace beatlas::cli
