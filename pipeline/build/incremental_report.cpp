// The report of a study that is built, gathered for the room `report`.

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <utility>

#include "pipeline/build/incremental_build.h"
#include "pipeline/build/report_facts.h"
#include "pipeline/build/study_status.h"
#include "pipeline/build/surface_bands.h"
#include "pipeline/build/version.h"
#include "pipeline/report/report_data.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"
#include "runtime/base/sha256.h"

namespace beatlas::build {
namespace fs = std::filesystem;
using nlohmann::json;
using study::Stage;
namespace {

constexpr auto kReportPage = "report.html";
constexpr auto kReportSummary = "report.json";
constexpr auto kSelfTest = "self_test.json";
constexpr auto kOfSegmentation = "of_segmentation";  ///< of it: what it was measured of

/// Hashes of a stage's outputs as they lie there, edited or not.
json outputs_now(const study::Study& study, Stage stage) {
  json outputs = study.find(stage)->outputs;
  for (const std::string& edited : study::edited_outputs(study, stage)) {
    const fs::path file = study.folder() / edited;
    outputs[edited] = fs::exists(file) ? study::sha256_of_file(file) : "gone";
  }
  return outputs;
}

std::string sha256_of(const json& value) {
  const std::string text = value.dump();
  return sha256_hex(std::as_bytes(std::span(text)));
}

/// What the study was last tested with; null if its labels are others since.
json self_test_of(const study::Study& study) {
  const fs::path file = study.folder() / kSelfTest;
  if (!fs::exists(file) || study.find(Stage::Segment) == nullptr) return {};
  try {
    json kept = study::read_json(file);
    const bool same = kept.is_object() && kept.value(kOfSegmentation, "") ==
                                              sha256_of(outputs_now(study, Stage::Segment));
    return same ? kept : json();
  } catch (const Error&) {
    return {};
  }
}

/// Of all that the report tells.
std::string made_from(const study::Study& study) {
  const auto& refusal = study.refusal();
  json all{{"program", {kVersion, sources_sha256()}},
           {"refused", refusal ? refusal->reason : std::string()},
           {"given", study.given()},
           {"self_test", self_test_of(study)}};
  for (const Stage stage : study::kAllStages) {
    const study::StageRecord* record = study.find(stage);
    if (record == nullptr) continue;
    all[std::string(study::stage_name(stage))] = {{"options", record->options},
                                                  {"outputs", outputs_now(study, stage)},
                                                  {"package", record->package_sha256}};
  }
  return sha256_of(all);
}

/// report.json of the build before; null if there is none that can be read.
json former_summary(const fs::path& file) {
  try {
    json former = study::read_json(file);
    return former.is_object() ? former : json();
  } catch (const Error&) {
    return {};
  }
}

/// What of `former` stands beside a new report: nothing older than the last one that differs.
json before_of(json former, const json& now) {
  if (former.is_null()) return {};
  json older = former.contains("before") ? former["before"] : json();
  for (const char* key : {"verdict", "figures", "places", "volumes_ml"}) {
    if (former.contains(key) && former[key] == now.at(key)) continue;
    former.erase("before");
    return former;
  }
  return older;
}

/// Whether a stage would run again.
bool is_behind(const report::ReportInput& input, Stage stage) {
  return std::any_of(input.stages.begin(), input.stages.end(),
                     [&](const report::ReportStage& known) {
                       return known.name == study::stage_name(stage) &&
                              (known.state == "stale" || known.state == "waits");
                     });
}

void tell_report(Listener& listener, const json& summary, const fs::path& page) {
  const std::string figures = told_figures(summary);
  if (!figures.empty()) listener.tell(figures);
  listener.tell(told_report(summary, page));
}

/// Whether a page is there and tells that it was made from that: report.json may have been written
/// with another page since.
bool is_page_of(const fs::path& page, const std::string& made_from) {
  std::ifstream file(page, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  return text.find(made_from) != std::string::npos;
}

}  // namespace

assess::SelfTest IncrementalBuild::self_test() {
  const Grid grid = exam().stack.grid();
  assess::SelfTest out;
  listener_.stage("assess", [&](StageContext& context) {
    out = assess::self_test(segmentation(), grid, facts_.rr_interval_s, orders_.recipe.registration,
                            context);
    json kept = to_json(out);
    kept[kOfSegmentation] = sha256_of(outputs_now(*study_, Stage::Segment));
    study::write_json(study_->folder() / kSelfTest, kept);
  });
  return out;
}

void IncrementalBuild::gather_labels(report::ReportInput& input) {
  reads_uncertainty_ = true;
  if (segmentation_ && segmentation_->uncertainty.empty()) segmentation_.reset();
  try {
    if (segmentation_ || study_->find(Stage::Segment) != nullptr) (void)segmentation();
  } catch (const Error& error) {
    // A leak that the recipe refuses: it is what the report has to show.
    if (error.code() != ErrorCode::Quality) throw;
  }
  input.exam = &exam();
  if (segmentation_) {
    input.segmentation = &*segmentation_;
    input.uncertainty = segmentation_->uncertainty;
    input.known = known_surfaces(*segmentation_);
  }
  input.drawn_seeds = orders_.seeds.size();
  if (!orders_.labels) return;
  const std::vector<int>& given = orders_.labels->phases;
  input.given_phases = {given.begin(), given.end()};
  for (int p = 0; given.empty() && p < input.exam->stack.phase_count(); ++p) {
    input.given_phases.insert(p);
  }
}

void IncrementalBuild::gather_surfaces(report::ReportInput& input, const StageContext& context) {
  // A build that was refused by its labels leaves the surfaces of those before, which the page
  // would show beside them.
  const bool stale = study_->refusal() && is_behind(input, Stage::Mesh);
  if (study_->find(Stage::Mesh) == nullptr || stale) return;
  input.surfaces = surface_cycles();
  for (const SurfaceCycle& surface : input.surfaces) {
    context.check_cancelled();
    input.surface_figures.push_back(surface_figures(surface));
  }
}

void IncrementalBuild::gather_package(report::ReportInput& input) {
  input.needed = needed(told_scene());
  const study::StageRecord* packed = study_->find(Stage::Pack);
  input.has_made_package = packed != nullptr && !packed->package_sha256.empty();
  // What lies there from before a refusal is of other labels or options.
  if (study_->refusal()) {
    input.refused = study_->refusal()->reason;
  } else {
    input.package = packed_facts(*study_);
  }
}

json IncrementalBuild::report(const fs::path& page, bool anew) {
  if (!study_->find(Stage::Import)) require(Stage::Import);
  // What is looked at here, painted labels, replaces no build's refusal.
  refused_ = refused_ || study_->refusal().has_value();
  const fs::path summary_file = study_->folder() / kReportSummary;
  const fs::path file = page.empty() ? study_->folder() / kReportPage : page;
  const std::string from = made_from(*study_);
  json former = former_summary(summary_file);
  const bool same = former.is_object() && former.value("made_from", "") == from;
  if (!anew && same && is_page_of(file, from)) {
    tell_report(listener_, former, file);
    return former;
  }

  json summary;
  listener_.stage("report", [&](StageContext& context) {
    report::ReportInput input;
    gather_labels(input);
    context.progress(0.3);
    context.check_cancelled();
    if (study_->find(Stage::Register) != nullptr) {
      input.workspace_from_lps = study::read_workspace_from_lps(study_->folder());
    }
    input.stages = stage_facts(*study_, listener_.times());
    gather_surfaces(input, context);
    context.progress(0.6);
    gather_package(input);
    const auto& inputs = study_->find(Stage::Import)->inputs;
    if (inputs.count(study::kSourceStack) != 0) {
      input.input_sha256 = inputs.at(study::kSourceStack);
    }
    input.program = std::string("beatlas ") + kVersion;
    input.made_from = from;
    input.self_test = self_test_of(*study_);
    summary = report::report_summary(input);
    input.before = before_of(std::move(former), summary);
    summary["before"] = input.before;
    const std::string html = report::report_html(report::report_json(input));
    context.check_cancelled();
    study::write_text(file, html);
    study::write_json(summary_file, summary);
  });
  tell_report(listener_, summary, file);
  return summary;
}

}  // namespace beatlas::build
