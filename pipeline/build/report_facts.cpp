#include "pipeline/build/report_facts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "pipeline/assess/surface_checks.h"
#include "pipeline/build/study_status.h"
#include "pipeline/core/parallel.h"
#include "pipeline/pack/pack.h"
#include "pipeline/study/files.h"
#include "runtime/atlas/info.h"
#include "runtime/base/error.h"

namespace beatlas::build {
using nlohmann::json;
using study::Stage;
namespace {

constexpr auto kEnclosed = "enclosed_ml";

/// How far the item may be from what it was made from, in words; nothing if its maker did not tell.
std::string error_of(const atlas::Item& item, const json& options, const json& contents) {
  char text[160] = "";
  const auto step = [&](const char* key) {
    const auto found = options.find(key);
    return found != options.end() && found->is_number() ? found->get<double>() : 0;
  };
  const double step_mm = item.kind == "field"
                             ? step(item.structure == "heart" ? "step_mm" : "nested_step_mm")
                             : step("surface_step_mm");
  if (item.kind == "field" && step_mm > 0) {
    std::snprintf(text, sizeof text, "distances within %g mm (a third of %g mm RMS)",
                  pack::kMostErrorSteps * step_mm, step_mm);
  } else if ((item.kind == "surface" || item.kind == "motion") && step_mm > 0) {
    std::snprintf(text, sizeof text, "vertices within %g mm in every phase", step_mm);
  } else if (item.kind == "volume" && contents.contains("volume") &&
             contents["volume"].is_object()) {
    const json& volume = contents["volume"];
    if (volume.value("psnr_db", json()).is_number()) {
      std::snprintf(text, sizeof text, "PSNR %.1f dB; RMS %.2f of the images' noise",
                    volume["psnr_db"].get<double>(),
                    volume["rms_error"].get<double>() / volume["noise"].get<double>());
    }
  }
  return text;
}

/// Of a level of detail it tells the length of edges, by which they differ.
std::string what_of(const atlas::Item& item, const std::vector<double>& edges_mm) {
  const std::string kind = item.kind == "field"     ? "distance field"
                           : item.kind == "surface" ? "surface"
                           : item.kind == "motion"  ? "motion of the surface"
                           : item.kind == "volume"  ? "images"
                                                    : "map of the wall";
  const auto level = static_cast<std::size_t>(item.level);
  const bool has_levels = item.kind != "field" && item.kind != "volume" && edges_mm.size() > 1;
  if (!has_levels || level >= edges_mm.size()) return item.structure + ", " + kind;
  char edges[48];
  std::snprintf(edges, sizeof edges, ", edges of %g mm", edges_mm[level]);
  return item.structure + ", " + kind + edges;
}

void put_worst_gap(const json& provenance, report::ReportPackage& out) {
  if (!provenance.contains("quality")) return;
  for (const json& entry : provenance["quality"]) {
    for (const char* made : {"field", "surface"}) {
      const std::string key = std::string(made) + "_volume_gap_percent";
      if (!entry.contains(key) || entry[key].get<double>() < out.worst_gap_percent.value_or(0)) {
        continue;
      }
      out.worst_gap_percent = entry[key].get<double>();
      // Packages of before tell no sign and no phase.
      const json excess = entry.value(std::string(made) + "_volume_excess_percent", json(nullptr));
      out.worst_gap_sign = excess.is_number() ? (excess.get<double>() > 0 ? 1 : -1) : 0;
      out.worst_gap_of = std::string("the ") + made + " of " + entry.value("name", "");
      const json phase = entry.value(std::string(made) + "_volume_gap_phase", json(nullptr));
      if (phase.is_number_integer()) {
        out.worst_gap_of += " in phase " + std::to_string(phase.get<int>());
      }
    }
  }
}

}  // namespace

report::SurfaceFigures surface_figures(const SurfaceCycle& surface) {
  report::SurfaceFigures out{surface.structure, 0, 0, 0};
  out.open_edges = static_cast<double>(assess::open_edges(surface.triangles));
  out.pinched_vertices = static_cast<double>(assess::pinched_vertices(surface.triangles));
  std::vector<double> crossing(surface.positions.size());
  parallel_for(crossing.size(), [&](std::size_t p) {
    crossing[p] =
        static_cast<double>(assess::crossing_triangles(surface.triangles, surface.positions[p]));
  });
  const double most = *std::max_element(crossing.begin(), crossing.end());
  out.crossing_percent = 100 * most / static_cast<double>(surface.triangles.size());
  return out;
}

std::string told_figures(const json& summary) {
  const json& figures = summary.at("figures");
  const json intervals = summary.value("intervals_90", json::object());
  std::string out;
  for (const auto& [key, name, unit] : {std::tuple{"lv_edv_ml", "EDV", "ml"},
                                        {"lv_esv_ml", "ESV", "ml"},
                                        {"lv_ef_percent", "EF", "%"}}) {
    if (!figures.at(key).is_number()) continue;
    // As the page rounds.
    const auto whole = [](const json& value) {
      return std::to_string(std::lround(value.get<double>()));
    };
    out +=
        (out.empty() ? "LV: " : ", ") + std::string(name) + " " + whole(figures[key]) + " " + unit;
    if (intervals.contains(key)) {
      out += " (90 %: " + whole(intervals[key][0]) + " to " + whole(intervals[key][1]) + ")";
    }
  }
  return out;
}

std::string told_report(const json& summary, const std::filesystem::path& page) {
  std::string out = "verdict: " + summary.at("verdict").get<std::string>();
  for (const json& reason : summary.at("reasons")) {
    out += "; " + reason.at("sentence").get<std::string>();
  }
  return out + "; see " + page.string();
}

std::vector<report::VolumeCurve> enclosed_volumes(const atlas::Atlas& package) {
  std::vector<report::VolumeCurve> out;
  for (const Structure structure : kAllStructures) {
    const auto surface = package.surface(structure);
    if (!surface) continue;
    report::VolumeCurve curve{structure, {}};
    for (const std::vector<Vec3f>& phase : surface->positions) {
      curve.volume_ml.push_back(assess::enclosed_volume_ml(surface->triangles, phase));
    }
    out.push_back(std::move(curve));
  }
  return out;
}

json pack_contents(const atlas::Manifest& manifest, std::uint64_t bytes,
                   const std::vector<assess::Check>& checks,
                   const std::vector<report::VolumeCurve>& enclosed) {
  json volumes = json::object();
  for (const report::VolumeCurve& curve : enclosed) {
    volumes[std::string(structure_name(curve.structure))] = curve.volume_ml;
  }
  return {{kEnclosed, volumes},
          {"bytes", bytes},
          {"manifest", atlas::manifest_to_json(manifest)},
          {"checks", assess::checks_to_json(checks)},
          {"volume", atlas::info_json(manifest).at("volume")}};
}

report::ReportPackage package_facts(const json& contents, const std::string& sha256) {
  const atlas::Manifest manifest = atlas::manifest_from_json(contents.at("manifest"));
  report::ReportPackage out;
  out.scene = manifest.scene;
  out.sha256 = sha256;
  out.bytes = contents.at("bytes").get<std::uint64_t>();
  const json::json_pointer told("/stages/pack/options");
  const json options =
      manifest.provenance.contains(told) ? manifest.provenance.at(told) : json::object();
  for (const atlas::Item& item : manifest.items) {
    out.items.push_back({what_of(item, manifest.surface_edges_mm), item.bytes, item.sha256,
                         error_of(item, options, contents)});
  }
  for (const atlas::StructureEntry& entry : manifest.structures) {
    if (const auto structure = structure_from_name(entry.name)) {
      out.volumes.push_back({*structure, entry.volume_ml});
    }
  }
  // A package of before was not measured.
  const json enclosed = contents.value(kEnclosed, json::object());
  for (const auto& [name, volume_ml] : enclosed.items()) {
    if (const auto structure = structure_from_name(name)) {
      out.enclosed.push_back({*structure, volume_ml.get<std::vector<double>>()});
    }
  }
  put_worst_gap(manifest.provenance, out);
  if (contents.contains("checks")) {
    const json& checks = contents["checks"];
    out.checks = checks.at("checks").size();
    out.failed_checks = checks.at("failures").get<std::vector<std::string>>();
  }
  return out;
}

std::optional<report::ReportPackage> packed_facts(const study::Study& study) {
  const study::StageRecord* record = study.find(Stage::Pack);
  if (record == nullptr || record->outputs.count(kPackContents) == 0) return {};
  const std::filesystem::path file = study.folder() / kPackContents;
  const json contents = study::read_json(file);
  try {
    return package_facts(contents, record->package_sha256);
  } catch (const json::exception&) {
    throw_invalid(file.string() + " was changed by hand; make the package anew");
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

std::vector<report::ReportStage> stage_facts(const study::Study& study,
                                             const std::vector<report::StageTime>& times) {
  std::vector<report::ReportStage> out;
  for (const StageStatus& status : status_of(study).stages) {
    report::ReportStage stage;
    stage.name = std::string(study::stage_name(status.stage));
    stage.state = status.state;
    stage.edited = status.edited;
    if (const study::StageRecord* record = study.find(status.stage)) {
      stage.version = record->version;
      stage.options = record->options;
      stage.warnings = record->warnings;
    }
    for (const report::StageTime& time : times) {
      if (time.stage == stage.name) stage.wall_s = time.wall_s;
    }
    out.push_back(std::move(stage));
  }
  return out;
}

}  // namespace beatlas::build
