/// Alternatives beside our own in one run: Markdown or JSON on stdout.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "pipeline/assess/bench_phantom.h"
#include "pipeline/cli/bench_probe.h"
#include "pipeline/core/parallel.h"
#include "pipeline/field/field.h"
#include "pipeline/phantom/render.h"
#include "pipeline/segment/segment.h"
#include "pipeline/shape/workspace.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "tests/bench/alternatives.h"
#include "tests/learned.h"

namespace beatlas::bench {
namespace {

using nlohmann::json;

constexpr double kCreaseMm = 2;
constexpr std::size_t kPointsAPhase = 1500;

phantom::PhantomSpec spec_of(const std::string& preset) {
  phantom::PhantomSpec spec = phantom::preset(preset);
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  return spec;
}

/// Goes with the object, whatever ends the program.
class WorkFolder {
 public:
  WorkFolder()
      : path_(std::filesystem::temp_directory_path() /
              ("beatlas-alternatives-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~WorkFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void tell(const std::string& line) { std::cerr << "alternatives_bench: " << line << "\n"; }

Setting setting_of(const std::string& preset, int repeats, const std::filesystem::path& work) {
  StageContext quiet;
  phantom::Phantom phantom(spec_of(preset));
  tell("imaging the phantom " + preset);
  phantom::Rendering rendering = phantom::render(phantom, quiet);
  Exam exam;
  exam.stack = std::move(rendering.cine);
  tell("segmenting, making fields, asking the closed form");
  const prior::PriorCycle prior = test::learned(exam);
  Segmentation found = segment::segment_exam(exam, {}, {}, quiet, {}, &prior);
  const Affine map = shape::workspace_from_lps(exam.stack.grid(), found.coverage);
  std::vector<ShapeCycle> shapes = shape::shapes_in_workspace(found, map, {}, quiet);
  const auto heart = std::find_if(shapes.begin(), shapes.end(), [](const ShapeCycle& shape) {
    return shape.structure == Structure::Heart;
  });
  if (heart == shapes.end()) throw_invalid("no heart was found in the phantom " + preset);
  const shape::RegisterOptions registration;
  const ShapeCycle exact = assess::exact_shape(
      phantom, Structure::Heart, map, registration.shape_mm, registration.margin_mm, quiet);
  FieldCycle field = field::build_field(*heart, {}, quiet);
  FieldCycle exact_field = field::build_field(exact, {}, quiet);
  assess::TruthSet truth = assess::make_truth_set(phantom, {Structure::Heart}, {}, quiet);
  return {.phantom = std::move(phantom),
          .exam = std::move(exam),
          .truth_labels = std::move(rendering.labels),
          .found = std::move(found),
          .workspace_from_lps = map,
          .shape = std::move(*heart),
          .field = std::move(field),
          .exact_field = std::move(exact_field),
          .truth = std::move(truth),
          .repeats = repeats,
          .work = work};
}

std::string number(double value, int decimals) {
  std::array<char, 64> text{};
  const int length = std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return {text.data(), static_cast<std::size_t>(length)};
}

/// Two significant digits.
std::string ratio_text(double ratio) {
  const int decimals = ratio >= 9.95 ? 0 : ratio >= 0.995 ? 1 : ratio >= 0.0995 ? 2 : 3;
  return "x " + number(ratio, decimals);
}

/// None where there is nothing to compare with.
std::optional<double> ratio_of(const Table& table, std::size_t row, std::size_t column) {
  const auto& ours = table.rows.front().figures[column];
  const auto& figure = table.rows[row].figures[column];
  if (row == 0 || !table.columns[column].as_ratio || !ours || !figure || !(*ours > 0)) return {};
  return *figure / *ours;
}

void write_markdown(const Table& table) {
  std::cout << "## " << table.title << "\n" << table.note << "\n\n|";
  for (const Column& column : table.columns) std::cout << " | " << column.heading;
  std::cout << " |\n|---|";
  for (std::size_t c = 0; c < table.columns.size(); ++c) std::cout << "---|";
  std::cout << "\n";
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    std::cout << "| " << table.rows[r].name;
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const auto& figure = table.rows[r].figures[c];
      std::cout << " | " << (figure ? number(*figure, table.columns[c].decimals) : "-");
      const auto ratio = ratio_of(table, r, c);
      if (ratio) std::cout << " (" << ratio_text(*ratio) << ")";
    }
    std::cout << " |\n";
  }
  std::cout << "\n";
}

json to_json(const Table& table) {
  json rows = json::array();
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    json row{{"name", table.rows[r].name}};
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const auto& figure = table.rows[r].figures[c];
      row[table.columns[c].key] = figure ? json(*figure) : json(nullptr);
      const auto ratio = ratio_of(table, r, c);
      if (ratio) row[table.columns[c].key + "_to_ours"] = *ratio;
    }
    rows.push_back(std::move(row));
  }
  return {{"title", table.title}, {"note", table.note}, {"rows", rows}};
}

int run(int argc, char** argv) {
  CLI::App app{"Measures what a user would take instead beside our own, on a phantom, in one run"};
  std::string preset = "small";
  int repeats = 5;
  bool as_json = false;
  app.add_option("--preset", preset, "phantom: " + CLI::detail::join(phantom::preset_names()))
      ->capture_default_str();
  app.add_option("--repeats", repeats, "turns of which medians are taken, 1..50")
      ->check(CLI::Range(1, 50))
      ->capture_default_str();
  app.add_flag("--json", as_json, "JSON instead of Markdown");
  std::string only;
  app.add_option("--only", only, "one table alone")
      ->check(CLI::IsMember({"segmentation", "surface", "field", "storage", "mesh"}));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const WorkFolder work;
  const Setting setting = setting_of(preset, repeats, work.path());
  using Make = Table (*)(const Setting&);
  const std::vector<std::pair<std::string, Make>> parts{{"segmentation", segmentation_table},
                                                        {"surface", surface_table},
                                                        {"field", field_table},
                                                        {"storage", storage_table},
                                                        {"mesh", mesh_table}};
  std::vector<Table> tables;
  for (const auto& [name, make] : parts) {
    if (!only.empty() && name != only) continue;
    tell("measuring: " + name);
    tables.push_back(make(setting));
  }
  const Index3& size = setting.exam.stack.grid().size;
  if (as_json) {
    json out{
        {"preset", preset}, {"phases", setting.phases()}, {"size", size}, {"repeats", repeats}};
    for (const Table& table : tables) out[table.key] = to_json(table);
    std::cout << json_text(out, 2) << "\n";
    return 0;
  }
  std::cout << "# Alternatives, phantom " << preset << "\n"
            << setting.phases() << " phases of " << size[0] << " x " << size[1] << " x " << size[2]
            << " voxels; medians of interleaved turns; in brackets the multiple of ours (the first "
               "row).\n\n";
  for (const Table& table : tables) write_markdown(table);
  return 0;
}

}  // namespace

std::vector<std::vector<double>> interleaved(
    int repeats, const std::vector<std::function<std::vector<double>()>>& candidates) {
  std::vector<std::vector<std::vector<double>>> figures(candidates.size());  // [][figure][turn]
  for (int turn = 0; turn <= repeats; ++turn) {
    for (std::size_t n = 0; n < candidates.size(); ++n) {
      const std::vector<double> taken = candidates[n]();
      figures[n].resize(taken.size());
      for (std::size_t f = 0; f < taken.size() && turn > 0; ++f) figures[n][f].push_back(taken[f]);
    }
  }
  std::vector<std::vector<double>> out(candidates.size());
  for (std::size_t n = 0; n < candidates.size(); ++n) {
    for (const std::vector<double>& turns : figures[n]) out[n].push_back(cli::median(turns));
  }
  return out;
}

double clocked_ms(const std::function<void()>& work) {
  const double start = cli::wall_clock_s();
  work();
  return 1e3 * (cli::wall_clock_s() - start);
}

DistanceErrors summed_errors(std::vector<double> errors) {
  DistanceErrors out;
  if (errors.empty()) return out;
  for (double& error : errors) {
    out.bias_mm += error / static_cast<double>(errors.size());
    error = std::abs(error);
    out.mean_mm += error / static_cast<double>(errors.size());
  }
  const auto at =
      static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(errors.size())) - 1);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(at), errors.end());
  out.p95_mm = errors[at];
  return out;
}

std::vector<double> distances_to_truth(const Setting& setting, int phase,
                                       const std::vector<Vec3>& points_lps) {
  const auto frame = setting.phantom.frame(setting.phantom.phase_time_s(phase));
  const std::size_t step = std::max<std::size_t>(1, points_lps.size() / kPointsAPhase);
  std::vector<std::optional<double>> found((points_lps.size() + step - 1) / step);
  parallel_for(found.size(), [&](std::size_t n) {
    const phantom::Nearest nearest = frame->nearest(Structure::Heart, points_lps[n * step]);
    if (frame->crease_distance_mm(Structure::Heart, nearest.point) < kCreaseMm) return;
    found[n] = nearest.distance_mm;
  });
  std::vector<double> out;
  for (const auto& each : found) {
    if (each) out.push_back(*each);
  }
  return out;
}

atlas::Manifest manifest_of(const Setting& setting, const std::string& scene) {
  atlas::Manifest out;
  out.scene = scene;
  out.rr_interval_s = setting.rr_interval_s();
  out.frame_times_s = setting.exam.stack.frame_times_s;
  out.workspace_from_lps = setting.workspace_from_lps;
  out.source_size = setting.exam.stack.grid().size;
  out.source_lps_from_index = setting.exam.stack.grid().mm_from_index;
  out.end_diastole = setting.found.end_diastole;
  out.end_systole = setting.found.end_systole;
  out.structures = {{std::string(structure_name(Structure::Heart)), setting.field.volume_ml}};
  return out;
}

Mask mask_of(const LabelCycle& labels, int phase, Structure structure) {
  const std::vector<std::uint8_t>& from = labels.phases[static_cast<std::size_t>(phase)];
  Mask out(from.size());
  for (std::size_t n = 0; n < from.size(); ++n) {
    out[n] = label_in_structure(from[n], structure) ? 1 : 0;
  }
  return out;
}

}  // namespace beatlas::bench

int main(int argc, char** argv) {
  try {
    return beatlas::bench::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "alternatives_bench: " << error.what() << "\n";
    return 1;
  }
}
