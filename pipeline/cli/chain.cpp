#include "pipeline/cli/chain.h"

#include <algorithm>
#include <span>
#include <utility>

#include "pipeline/cli/fingerprint.h"
#include "pipeline/cli/quality.h"
#include "pipeline/cli/seeds.h"
#include "pipeline/cli/version.h"
#include "pipeline/report/overlay.h"
#include "pipeline/report/segmented_volume.h"
#include "pipeline/study/files.h"
#include "runtime/atlas/scene.h"
#include "runtime/base/error.h"
#include "runtime/base/sha256.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
using nlohmann::json;
using study::Stage;
namespace {

double frame_interval_s(const Cine& cine) {
  return cine.rr_interval_s / std::max(1, cine.phase_count());
}

std::string sha256_of_text(const std::string& text) {
  return sha256_hex(std::as_bytes(std::span(text)));
}

}  // namespace

bool scene_has_surfaces(const Scene& scene) {
  return std::any_of(kAllStructures.begin(), kAllStructures.end(), [&](Structure structure) {
    return atlas::scene_holds(scene.content, atlas::kSurfaceKind, structure);
  });
}

Chain::Chain(Console& console, Recipe recipe, std::optional<study::Study> study)
    : console_(console), recipe_(std::move(recipe)), study_(std::move(study)) {}

void Chain::note(Stage stage, json options, const study::FileList& files) {
  if (study_) study_->commit(stage, kVersion, options, files, facts_.input_sha256);
  facts_.stages[stage] = {kVersion, std::move(options)};
}

void Chain::note_exam(const Exam& exam) {
  facts_.source_format = exam.source_format;
  facts_.decisions = exam.decisions;
  facts_.source = exam.stack.grid();
  facts_.rr_interval_s = exam.stack.rr_interval_s;
  facts_.frame_times_s = exam.stack.frame_times_s;
}

void Chain::note_segmentation(const Segmentation& segmentation) {
  facts_.end_diastole = segmentation.end_diastole;
  facts_.end_systole = segmentation.end_systole;
  facts_.warnings = segmentation.warnings;
  facts_.volumes.clear();
  for (Structure structure : kAllStructures) {
    if (segmentation.coverage.phases.count(structure) == 0) {
      facts_.warnings.push_back(std::string(structure_name(structure)) +
                                " was not found; the package lacks it");
      continue;
    }
    facts_.volumes.push_back({structure, report::segmented_volume_ml(segmentation, structure)});
  }
}

Exam Chain::import(const std::vector<fs::path>& sources) {
  Exam exam;
  console_.stage("import", [&](StageContext& context) {
    exam = ingest::read_exam(sources, recipe_.import, context);
    facts_.input_sha256 = stack_sha256(exam.stack);
    note_exam(exam);
    study::FileList files;
    if (study_) files = study::write_exam(study_->folder(), exam);
    note(Stage::Import, stage_options(recipe_, Stage::Import), files);
  });
  for (const std::string& decision : exam.decisions) console_.tell("import: " + decision);
  return exam;
}

Segmentation Chain::segment(const Exam& exam, const std::vector<segment::Seed>& seeds) {
  Segmentation segmentation;
  console_.stage("segment", [&](StageContext& context) {
    segmentation = segment::segment_exam(exam, seeds, recipe_.segment, context);
    note_segmentation(segmentation);
    json options = stage_options(recipe_, Stage::Segment);
    if (!seeds.empty()) {
      options["seeds"] = {{"count", seeds.size()},
                          {"sha256", sha256_of_text(seeds_to_json(seeds).dump())}};
    }
    study::FileList files;
    if (study_) {
      files =
          study::write_segmentation(study_->folder(), segmentation, frame_interval_s(exam.stack));
      write_pictures(exam, segmentation);
      files.insert(files.end(), {"pictures/overlay.png", "pictures/volumes.svg"});
    }
    note(Stage::Segment, std::move(options), files);
  });
  for (const std::string& warning : facts_.warnings) console_.warn(warning);
  return segmentation;
}

void Chain::write_pictures(const Exam& exam, const Segmentation& segmentation) {
  const fs::path folder = study_->folder() / "pictures";
  study::make_folder(folder);
  study::write_bytes(folder / "overlay.png", report::overlay_png(exam.stack, segmentation));
  study::write_text(folder / "volumes.svg",
                    report::volume_curves_svg(facts_.volumes, exam.stack.rr_interval_s,
                                              facts_.end_diastole, facts_.end_systole));
}

study::Registration Chain::registration(const Exam& exam, const Segmentation& segmentation) {
  study::Registration out;
  console_.stage("register", [&](StageContext& context) {
    out.workspace_from_lps = reg::workspace_from_lps(exam.stack.grid(), segmentation.coverage);
    out.shapes = reg::shapes_in_workspace(segmentation, out.workspace_from_lps,
                                          recipe_.registration, context);
    facts_.workspace_from_lps = out.workspace_from_lps;
    study::FileList files;
    if (study_) {
      files = study::write_registration(
          study_->folder(), out, reg::cine_in_workspace(exam.stack, out.workspace_from_lps),
          reg::labels_in_workspace(out.shapes), frame_interval_s(exam.stack));
    }
    note(Stage::Register, stage_options(recipe_, Stage::Register), files);
  });
  return out;
}

std::vector<FieldCycle> Chain::fields(const std::vector<ShapeCycle>& shapes) {
  std::vector<FieldCycle> out;
  console_.stage("field", [&](StageContext& context) {
    for (const ShapeCycle& shape : shapes) {
      context.check_cancelled();
      out.push_back(field::build_field(shape, recipe_.field, context));
    }
    study::FileList files;
    if (study_) files = study::write_fields(study_->folder(), out);
    note(Stage::Field, stage_options(recipe_, Stage::Field), files);
  });
  return out;
}

std::vector<SurfaceCycle> Chain::surfaces(const std::vector<FieldCycle>& fields) {
  std::vector<SurfaceCycle> out;
  console_.stage("mesh", [&](StageContext& context) {
    for (const FieldCycle& field : fields) {
      context.check_cancelled();
      out.push_back(mesh::mesh_cycle(field, recipe_.mesh, context));
    }
    study::FileList files;
    if (study_) files = study::write_surfaces(study_->folder(), out);
    note(Stage::Mesh, stage_options(recipe_, Stage::Mesh), files);
  });
  return out;
}

void Chain::pack(const std::vector<FieldCycle>& fields, std::vector<SurfaceCycle> surfaces,
                 const Scene& scene, const fs::path& file) {
  console_.stage("pack", [&](StageContext& context) {
    std::vector<SurfaceCycle> used;
    for (const FieldCycle& field : fields) {
      if (!atlas::scene_holds(scene.content, atlas::kSurfaceKind, field.structure)) continue;
      const auto surface = std::find_if(
          surfaces.begin(), surfaces.end(),
          [&](const SurfaceCycle& candidate) { return candidate.structure == field.structure; });
      if (surface == surfaces.end()) {
        throw_invalid("there is no surface of " + std::string(structure_name(field.structure)) +
                      ", which the scene " + scene.content + " needs; run the stage mesh again");
      }
      used.push_back(std::move(*surface));
    }
    const auto quality = measure_quality(facts_.volumes, fields, used);
    demand_quality(quality, recipe_.quality);

    pack::PackageContent content;
    atlas::Manifest& manifest = content.manifest;
    manifest.scene = scene.content;
    manifest.stiffness_n_per_m = scene.stiffness_n_per_m;
    manifest.rr_interval_s = facts_.rr_interval_s;
    manifest.frame_times_s = facts_.frame_times_s;
    manifest.workspace_from_lps = facts_.workspace_from_lps;
    manifest.source_size = facts_.source.size;
    manifest.source_lps_from_index = facts_.source.mm_from_index;
    manifest.end_diastole = facts_.end_diastole;
    manifest.end_systole = facts_.end_systole;
    for (const FieldCycle& field : fields) {
      manifest.structures.push_back(
          {std::string(structure_name(field.structure)), field.volume_ml});
    }
    json stages = json::object();
    for (const auto& [stage, fact] : facts_.stages) {
      if (stage == Stage::Mesh && used.empty()) continue;
      stages[std::string(study::stage_name(stage))] = {{"version", fact.version},
                                                       {"options", fact.options}};
    }
    const json pack_options = stage_options(recipe_, Stage::Pack);
    stages["pack"] = {{"version", kVersion}, {"options", pack_options}};
    manifest.provenance = {{"program", "beatlas"},
                           {"version", kVersion},
                           {"stages", stages},
                           {"input_sha256", facts_.input_sha256},
                           {"source_format", facts_.source_format},
                           {"decisions", facts_.decisions},
                           {"warnings", facts_.warnings},
                           {"quality", quality_to_json(quality)}};
    for (const FieldCycle& field : fields) {
      context.check_cancelled();
      if (!atlas::scene_holds(scene.content, atlas::kFieldKind, field.structure)) continue;
      content.fields.push_back(pack::encode_field(field, recipe_.pack));
      context.progress(static_cast<double>(content.fields.size()) /
                       static_cast<double>(fields.size()));
    }
    for (SurfaceCycle& surface : used) {
      content.surfaces.push_back(
          {surface.structure, std::move(surface.triangles), std::move(surface.positions)});
    }
    context.check_cancelled();
    pack::write_package(file, content);
    note(Stage::Pack, pack_options, {});
  });
}

void Chain::recall(Stage last) {
  for (Stage stage : study::kAllStages) {
    if (stage > last) break;
    const study::StageRecord& record = study_->record(stage);
    facts_.stages[stage] = {record.version, record.options};
  }
  const auto& inputs = study_->record(Stage::Import).inputs;
  if (const auto source = inputs.find("source"); source != inputs.end()) {
    facts_.input_sha256 = source->second;
  }
}

void Chain::recall_exam() {
  const fs::path& folder = study_->folder();
  note_exam(study::read_exam(folder));
  note_segmentation(study::read_segmentation(folder));
  facts_.workspace_from_lps = study::read_workspace_from_lps(folder);
}

}  // namespace beatlas::cli
