#include "pipeline/assess/bench_report.h"

#include <array>
#include <cstdio>
#include <limits>
#include <set>

namespace beatlas::assess {
using nlohmann::json;
namespace {

std::string fixed(double value, const char* format) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

std::string or_dash(const std::optional<double>& value, const char* format) {
  return value ? fixed(*value, format) : "-";
}

json or_null(const std::optional<double>& value) { return value ? json(*value) : json(nullptr); }

json errors_to_json(const SurfaceErrors& errors) {
  return {{"mean_mm", errors.mean_mm},
          {"p95_mm", errors.p95_mm},
          {"frames_mean_mm", errors.frames_mean_mm},
          {"bias_mm", errors.bias_mm},
          {"normal_p95_deg", errors.normal_p95_deg},
          {"points", errors.points}};
}

json row_to_json(const BenchRow& row) {
  json errors = json::object();
  for (const auto& [structure, each] : row.errors) {
    errors[std::string(structure_name(structure))] = errors_to_json(each);
  }
  json front = json::array();
  if (row.front_bytes) front.push_back("bytes");
  if (row.front_query) front.push_back("query");
  if (row.front_build) front.push_back("build");
  json out{{"knob", row.run.knob},
           {"sweep", sweep_name(row.run.sweep)},
           {"kind", family_name(row.run.family)},
           {"values", row.run.values},
           {"default", row.run.is_default},
           {"errors", errors},
           {"stage_s", row.stage_s},
           {"build_s", row.build_s},
           {"total_s", row.total_s},
           {"package_bytes", row.package_bytes},
           {"load_ms", row.load_ms},
           {"query_path_ns", or_null(row.query_path_ns)},
           {"query_random_ns", or_null(row.query_random_ns)},
           {"peak_memory_mb", or_null(row.peak_memory_mb)},
           {"front", front}};
  if (row.force) {
    out["force"] = {{"mean_n", row.force->mean_n},
                    {"p95_n", row.force->p95_n},
                    {"max_n", row.force->max_n},
                    {"ticks", row.force->contact_ticks}};
  }
  if (row.volume) {
    out["volume"] = {{"of_noise", row.volume->of_noise}, {"voxel_ns", row.volume->voxel_ns}};
  }
  if (row.draco_bits) out["draco_bits"] = *row.draco_bits;
  return out;
}

std::string error_of(const BenchRow& row, Structure structure) {
  const auto found = row.errors.find(structure);
  if (found == row.errors.end()) return "-";
  return fixed(found->second.mean_mm, "%.3f") + " / " + fixed(found->second.p95_mm, "%.3f");
}

std::string volume_line(const BenchRow& row) {
  std::string values = shown_values(row.run);
  if (row.run.is_default) values = "**" + values + "**";
  return "| " + values + " | " + fixed(row.volume->of_noise, "%.3f") + " | " +
         fixed(row.build_s, "%.2f") + " | " +
         fixed(static_cast<double>(row.package_bytes) * 1e-6, "%.3f") + " | " +
         fixed(row.load_ms, "%.1f") + " | " + fixed(row.volume->voxel_ns, "%.2f") + " |\n";
}

std::string table_line(const BenchRow& row) {
  if (row.volume) return volume_line(row);
  std::string values = shown_values(row.run);
  if (row.draco_bits) values += " (" + std::to_string(*row.draco_bits) + " bits)";
  if (row.run.family == Family::Published) values = "voxels, force linear in time";
  if (row.run.is_default && row.run.family != Family::Published) values = "**" + values + "**";
  std::string front;
  if (row.front_bytes) front += "B";
  if (row.front_query) front += "Q";
  if (row.front_build) front += "T";
  const auto heart = row.errors.find(Structure::Heart);
  std::string line = "| " + values;
  for (const std::string& cell :
       {error_of(row, Structure::Heart), error_of(row, Structure::LvBlood),
        error_of(row, Structure::RvBlood),
        heart == row.errors.end() ? std::string("-") : fixed(heart->second.frames_mean_mm, "%.4f"),
        heart == row.errors.end() ? std::string("-") : fixed(heart->second.normal_p95_deg, "%.2f"),
        row.force ? fixed(row.force->mean_n, "%.4f") + " / " + fixed(row.force->p95_n, "%.4f")
                  : std::string("-"),
        fixed(row.build_s, "%.2f") + " / " + fixed(row.total_s, "%.2f"),
        fixed(static_cast<double>(row.package_bytes) * 1e-6, "%.3f"), fixed(row.load_ms, "%.1f"),
        row.query_path_ns
            ? fixed(*row.query_path_ns, "%.0f") + " / " + or_dash(row.query_random_ns, "%.0f")
            : std::string("-"),
        or_dash(row.peak_memory_mb, "%.0f"), front}) {
    line += " | " + cell;
  }
  return line + " |\n";
}

/// All stages that rows of a series name.
std::set<std::string> stages_of(const BenchReport& report, const std::string& series) {
  std::set<std::string> stages;
  for (const ScalingRow& row : report.scaling) {
    if (row.series != series) continue;
    for (const auto& each : row.stage_s) stages.insert(each.first);
  }
  return stages;
}

std::string scaling_head(const std::string& series, const std::set<std::string>& stages) {
  std::string out =
      "\n## Scaling with " + std::string(series == "voxels" ? "the voxels of an image" : series) +
      "\n\nWhole builds, each from nothing, of all structures for the scene palpation. Memory is "
      "the highest resident during the build above what was resident before it.\n\n| " +
      series + " | ";
  for (const std::string& stage : stages) out += stage + " s | ";
  out += "total s | memory MB | package MB |\n|---|";
  for (std::size_t n = 0; n < stages.size() + 3; ++n) out += "---|";
  return out + "\n";
}

std::string scaling_line(const ScalingRow& row, const std::set<std::string>& stages) {
  std::string out = "| " + fixed(row.size, "%.0f");
  if (row.series == "voxels") out += " (x " + fixed(row.factor, "%.3g") + ")";
  for (const std::string& stage : stages) {
    const auto found = row.stage_s.find(stage);
    out += " | " + (found == row.stage_s.end() ? "-" : fixed(found->second, "%.2f"));
  }
  return out + " | " + fixed(row.total_s, "%.2f") + " | " + or_dash(row.peak_memory_mb, "%.0f") +
         " | " + fixed(static_cast<double>(row.package_bytes) * 1e-6, "%.2f") + " |\n";
}

std::string fitted_laws(const BenchReport& report, const std::string& series) {
  std::string out = "\nFitted: figure ~ size^exponent (rms of the logarithm's residual): ";
  bool first = true;
  for (const ScalingFit& fit : report.fits) {
    if (fit.series != series) continue;
    out += (first ? "" : ", ") + fit.what + " " + fixed(fit.law.exponent, "%.2f") + " (" +
           fixed(fit.law.residual, "%.2f") + ")";
    first = false;
  }
  return out + ".\n";
}

std::string scaling_tables(const BenchReport& report) {
  std::string out;
  for (const std::string series : {"voxels", "phases"}) {
    const std::set<std::string> stages = stages_of(report, series);
    if (stages.empty()) continue;
    out += scaling_head(series, stages);
    for (const ScalingRow& row : report.scaling) {
      if (row.series == series) out += scaling_line(row, stages);
    }
    out += fitted_laws(report, series);
  }
  return out;
}

}  // namespace

std::string shown_values(const BenchRun& run) {
  std::string out;
  for (const auto& [pointer, value] : run.values.items()) {
    if (!out.empty()) out += ", ";
    out += value.is_boolean()  ? (value.get<bool>() ? "on" : "off")
           : value.is_string() ? value.get<std::string>()
                               : fixed(value.get<double>(), "%g");
  }
  return out;
}

void mark_fronts(std::vector<BenchRow>& rows) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (const Sweep sweep : {Sweep::Images, Sweep::Exact}) {
    std::vector<std::array<double, 2>> bytes;
    std::vector<std::array<double, 2>> query;
    std::vector<std::array<double, 2>> build;
    for (const BenchRow& row : rows) {
      const auto heart = row.errors.find(Structure::Heart);
      const bool counts =
          row.run.sweep == sweep && row.run.family != Family::Surface && heart != row.errors.end();
      const double error = counts ? heart->second.mean_mm : kNone;
      bytes.push_back({error, static_cast<double>(row.package_bytes)});
      query.push_back({error, row.query_path_ns.value_or(kNone)});
      build.push_back({error, row.total_s});
    }
    const std::vector<bool> on_bytes = pareto_front(bytes);
    const std::vector<bool> on_query = pareto_front(query);
    const std::vector<bool> on_build = pareto_front(build);
    for (std::size_t n = 0; n < rows.size(); ++n) {
      if (rows[n].run.sweep != sweep) continue;
      rows[n].front_bytes = on_bytes[n];
      rows[n].front_query = on_query[n];
      rows[n].front_build = on_build[n];
    }
  }
}

std::vector<ScalingFit> fit_scaling(const std::vector<ScalingRow>& rows) {
  std::map<std::pair<std::string, std::string>, std::array<std::vector<double>, 2>> points;
  for (const ScalingRow& row : rows) {
    const auto add = [&](const std::string& what, double value) {
      auto& [x, y] = points[{row.series, what}];
      x.push_back(row.size);
      y.push_back(value);
    };
    for (const auto& [stage, seconds] : row.stage_s) add(stage, seconds);
    add("total", row.total_s);
    add("bytes", static_cast<double>(row.package_bytes));
    if (row.peak_memory_mb) add("memory", *row.peak_memory_mb);
  }
  std::vector<ScalingFit> out;
  for (const auto& [key, xy] : points) {
    if (std::set<double>(xy[0].begin(), xy[0].end()).size() < 2) continue;
    out.push_back({key.first, key.second, fit_power_law(xy[0], xy[1])});
  }
  return out;
}

json bench_to_json(const BenchReport& report) {
  json rows = json::array();
  for (const BenchRow& row : report.rows) rows.push_back(row_to_json(row));
  json scaling = json::array();
  for (const ScalingRow& row : report.scaling) {
    scaling.push_back({{"series", row.series},
                       {"size", row.size},
                       {"factor", row.factor},
                       {"stage_s", row.stage_s},
                       {"total_s", row.total_s},
                       {"package_bytes", row.package_bytes},
                       {"peak_memory_mb", or_null(row.peak_memory_mb)}});
  }
  json fits = json::array();
  for (const ScalingFit& fit : report.fits) {
    fits.push_back({{"series", fit.series},
                    {"what", fit.what},
                    {"exponent", fit.law.exponent},
                    {"factor", fit.law.factor},
                    {"residual", fit.law.residual},
                    {"points", fit.law.points}});
  }
  return {{"preset", report.preset},   {"version", report.version},
          {"quick", report.quick},     {"repeats", report.repeats},
          {"threads", report.threads}, {"phases", report.phases},
          {"wall_s", report.wall_s},   {"runs", rows},
          {"scaling", scaling},        {"fits", fits}};
}

std::string bench_to_markdown(const BenchReport& report) {
  std::string out = "# Speed against error: phantom `" + report.preset + "`, " +
                    std::to_string(report.phases) + " phases, " + std::to_string(report.threads) +
                    " threads\n";
  if (!report.rows.empty()) {
    out +=
        "\nOne option at a time around the defaults (bold), each figure from a package written and "
        "opened again. *mean / p95* is |distance| told at points of the true surface, where it is "
        "0, at moments between the frames as well as at them; creases are left out by 2 mm. *in "
        "frames* is the mean at times of frames alone: the error in space without that of "
        "interpolation in time. "
        "*normal* is the 95th percentile of the angle, of the heart. *force* is |F - F true|, mean "
        "/ p95, K 150 N/m, over eight palpations. *build* is the time of the stages that the "
        "option concerns / of all, for the heart's field; *MB* the package of the scene. *query* "
        "is the median along palpations at 1 kHz / at random points. *memory* is the highest "
        "resident while the stages ran, above what was held before. *front*: no other run of the "
        "same sweep is both nearer and smaller (B), faster to ask (Q) or to build (T).\n";
  }
  std::string knob;
  Sweep sweep{};
  for (const BenchRow& row : report.rows) {
    const bool surface = row.run.family == Family::Surface;
    if (row.run.knob != knob || row.run.sweep != sweep) {
      knob = row.run.knob;
      sweep = row.run.sweep;
      out += "\n## " + row.run.title + "\n\n";
      out +=
          row.volume
              ? "The images around the heart, as a package stores them. The error is the root mean "
                "square off images without noise, near the heart, over that of the images packed."
                "\n\n"
          : sweep == Sweep::Images
              ? "From images. The segmentation's error is in every figure, so compare with other "
                "tables from images only: a difference below it tells nothing.\n\n"
          : surface
              ? "From the exact shape. Errors of stored surfaces, of their triangles' corners "
                "and middles, in the frames only: compare them among themselves, not with those "
                "of fields.\n\n"
              : "From the exact shape: no error of images, only those of field, package and "
                "interpolation. Compare with other tables from the exact shape.\n\n";
      if (row.volume) {
        out +=
            "| value | error | pack s | MB | load ms | ns a voxel |\n"
            "|---|---|---|---|---|---|\n";
        out += table_line(row);
        continue;
      }
      out +=
          "| value | heart mm | LV blood mm | RV blood mm | heart in frames mm | normal deg | "
          "force N | build s | "
          "MB | load ms | query ns | memory MB | front |\n"
          "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    }
    out += table_line(row);
  }
  return out + scaling_tables(report);
}

}  // namespace beatlas::assess
