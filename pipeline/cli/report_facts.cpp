#include "pipeline/cli/report_facts.h"

#include <algorithm>
#include <cstdio>

#include "pipeline/cli/study_status.h"
#include "pipeline/pack/pack.h"
#include "pipeline/study/files.h"
#include "runtime/atlas/info.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
using nlohmann::json;
using study::Stage;
namespace {

/// How far the item may be from what it was made from, in words.
std::string error_of(const atlas::Item& item, const json& options, const json& contents) {
  char text[160] = "";
  if (item.kind == "field") {
    const double step_mm =
        options.at(item.structure == "heart" ? "step_mm" : "nested_step_mm").get<double>();
    std::snprintf(text, sizeof text, "distances within %g mm (a third of %g mm RMS)",
                  pack::kMostErrorSteps * step_mm, step_mm);
  } else if (item.kind == "surface" || item.kind == "motion") {
    std::snprintf(text, sizeof text, "vertices within %g mm in every phase",
                  options.at("surface_step_mm").get<double>());
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

std::string what_of(const atlas::Item& item) {
  const std::string kind = item.kind == "field"     ? "distance field"
                           : item.kind == "surface" ? "surface"
                           : item.kind == "motion"  ? "motion of the surface"
                           : item.kind == "volume"  ? "images"
                                                    : "map of the wall";
  return item.structure + ", " + kind;
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
      out.worst_gap_of = std::string("the ") + made + " of " + entry.value("name", "");
    }
  }
}

}  // namespace

json pack_contents(const atlas::Manifest& manifest, std::uint64_t bytes,
                   const std::vector<assess::Check>& checks) {
  return {{"bytes", bytes},
          {"manifest", atlas::manifest_to_json(manifest)},
          {"checks", assess::checks_to_json(checks)},
          {"volume", atlas::info_json(manifest).at("volume")}};
}

std::optional<report::ReportPackage> packed_facts(const study::Study& study) {
  const study::StageRecord* record = study.find(Stage::Pack);
  if (record == nullptr || record->outputs.count(kPackContents) == 0) return {};
  const std::filesystem::path file = study.folder() / kPackContents;
  const json contents = study::read_json(file);
  try {
    const atlas::Manifest manifest = atlas::manifest_from_json(contents.at("manifest"));
    report::ReportPackage out;
    out.scene = manifest.scene;
    out.sha256 = record->package_sha256;
    out.bytes = contents.at("bytes").get<std::uint64_t>();
    const json options = manifest.provenance.at("stages").at("pack").at("options");
    for (const atlas::Item& item : manifest.items) {
      out.items.push_back(
          {what_of(item), item.bytes, item.sha256, error_of(item, options, contents)});
    }
    for (const atlas::StructureEntry& entry : manifest.structures) {
      if (const auto structure = structure_from_name(entry.name)) {
        out.volumes.push_back({*structure, entry.volume_ml});
      }
    }
    put_worst_gap(manifest.provenance, out);
    if (contents.contains("checks")) {
      const json& checks = contents["checks"];
      out.checks = checks.at("checks").size();
      out.failed_checks = checks.at("failures").get<std::vector<std::string>>();
    }
    return out;
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

}  // namespace beatlas::cli
