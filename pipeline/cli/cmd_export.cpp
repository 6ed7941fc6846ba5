#include <array>
#include <cstdio>
#include <map>

#include <CLI/CLI.hpp>

#include "pipeline/build/study_status.h"
#include "pipeline/build/surfaces.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/editor_files.h"
#include "pipeline/cli/source_labels.h"
#include "pipeline/cli/stored_distances.h"
#include "pipeline/cli/stored_images.h"
#include "pipeline/core/parallel.h"
#include "pipeline/core/words.h"
#include "pipeline/field/field.h"
#include "pipeline/formats/gltf.h"
#include "pipeline/formats/label_table.h"
#include "pipeline/formats/obj.h"
#include "pipeline/mesh/nested.h"
#include "pipeline/study/files.h"
#include "pipeline/study/images.h"
#include "pipeline/study/json_values.h"
#include "pipeline/study/new_files.h"
#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

struct ExportArguments {
  CommonArguments common;
  std::string source;
  std::string to;
  std::string output;
  std::optional<int> phase;
};

/// What an export needs, whether it comes from a package or from a study.
struct Content {
  std::vector<std::shared_ptr<const atlas::FieldPayload>> fields;
  std::vector<std::shared_ptr<const atlas::SurfacePayload>> surfaces;
  Grid source;
  Affine workspace_from_lps = Affine::Identity();
  double rr_interval_s = 0;
  std::map<Structure, std::vector<double>> volume_ml;  ///< of each field
  std::optional<ImageCycle<float>> cine;
};

/// Labels need every structure, by its distances or, where there are none, as of atria and in a
/// scene of surfaces, by its surface; distances are those that the package holds.
atlas::Needs needs_of(const atlas::Manifest& manifest, const std::string& format) {
  atlas::Needs needs;
  const atlas::Needs held = atlas::everything_in(manifest);
  if (format == "vdb") {
    needs.fields = held.fields;
    if (needs.fields.empty()) needs.fields.insert(Structure::Heart);  // refused by its name
    return needs;
  }
  for (const atlas::StructureEntry& entry : manifest.structures) {
    const auto structure = structure_from_name(entry.name);
    if (!structure) continue;
    const bool by_surface =
        format != "nifti" || is_beyond_base(*structure) ||
        (held.fields.count(*structure) == 0 && held.surfaces.count(*structure) != 0);
    (by_surface ? needs.surfaces : needs.fields).insert(*structure);
  }
  needs.volume = format == "nifti" && held.volume;
  return needs;
}

Content from_package(const fs::path& file, const std::string& format) {
  const atlas::Manifest manifest = atlas::Atlas::open(file, {}).manifest();
  const atlas::Needs needs = needs_of(manifest, format);
  const atlas::Atlas package = atlas::Atlas::open(file, needs);
  Content content;
  for (Structure structure : needs.fields) content.fields.push_back(package.field(structure));
  for (Structure structure : needs.surfaces) content.surfaces.push_back(package.surface(structure));
  content.source = {manifest.source_size, manifest.source_lps_from_index};
  content.workspace_from_lps = manifest.workspace_from_lps;
  content.rr_interval_s = manifest.rr_interval_s;
  for (const atlas::StructureEntry& entry : manifest.structures) {
    const auto structure = structure_from_name(entry.name);
    if (structure) content.volume_ml[*structure] = entry.volume_ml;
  }
  if (const auto volume = package.volume()) {
    content.cine = images_of(*volume, content.source, content.workspace_from_lps);
  }
  return content;
}

void require_done(const study::Study& study, study::Stage stage) {
  for (const build::StageStatus& status : build::status_of(study).stages) {
    if (status.stage > stage || status.stage == study::Stage::Pictures) continue;
    if (status.state == "done" || status.state == "edited") continue;
    throw_invalid("in the study " + study.folder().string() + " the stage " +
                  std::string(study::stage_name(status.stage)) + " is " + status.state +
                  "; build it first: beatlas build --study " + shell_word(study.folder().string()) +
                  " -o X.beatlas");
  }
}

Content from_study(const fs::path& folder, const std::string& format) {
  const bool fields = format == "nifti" || format == "vdb";
  const study::Study study = study::Study::open(folder);
  Content content;
  require_done(study, fields ? study::Stage::Field : study::Stage::Mesh);
  Exam exam = study::read_exam(folder);
  content.source = exam.stack.grid();
  content.rr_interval_s = exam.stack.rr_interval_s;
  content.workspace_from_lps = study::read_workspace_from_lps(folder);
  if (!fields) {
    std::vector<SurfaceCycle> surfaces = study::read_surfaces(folder);
    mesh::part_structures(surfaces, study::read_fields(folder), build::edited_surfaces(study));
    for (SurfaceCycle& cycle : surfaces) {
      content.surfaces.push_back(std::make_shared<atlas::SurfacePayload>(atlas::SurfacePayload{
          cycle.structure, std::move(cycle.triangles), std::move(cycle.positions)}));
    }
    return content;
  }
  const build::Recipe recipe = build::orders_of(study).recipe;
  for (const FieldCycle& cycle : study::read_fields(folder)) {
    check_stop_flag();
    content.fields.push_back(
        std::make_shared<atlas::FieldPayload>(pack::stored_field(cycle, recipe.pack)));
    content.volume_ml[cycle.structure] = cycle.volume_ml;
  }
  content.cine = std::move(exam.stack.images);
  return content;
}

void export_obj(const Content& content, const fs::path& folder) {
  for (const auto& surface : content.surfaces) {
    for (std::size_t phase = 0; phase < surface->positions.size(); ++phase) {
      std::array<char, 80> name{};
      std::snprintf(name.data(), name.size(), "%s_%03zu.obj",
                    structure_name(surface->structure).data(), phase);
      study::write_text(folder / name.data(), formats::obj_text(*surface, phase));
    }
  }
}

void export_glb(const Content& content, const fs::path& folder) {
  study::write_bytes(
      folder / "heart.glb",
      formats::gltf_binary(content.surfaces, {content.workspace_from_lps, content.rr_interval_s}));
}

void export_vdb(const Content& content, const fs::path& folder, StageContext& context) {
  for (const auto& field : content.fields) {
    context.check_cancelled();
    const fs::path file = folder / (std::string(structure_name(field->structure)) + ".vdb");
    field::write_vdb(file, distances_of(field, content.volume_ml.at(field->structure)));
  }
}

void export_images(const Content& content, const fs::path& folder, StageContext& context) {
  if (content.source.count() == 0) {
    throw_invalid("this atlas was not made from images, so there is no grid for labels");
  }
  const LabelCycle labels =
      labels_from_shapes({content.fields, content.surfaces}, content.source,
                         content.workspace_from_lps, content.rr_interval_s, context);
  const double interval_s = content.rr_interval_s / labels.phase_count();
  study::write_labels(folder / "labels.nii.gz", labels.phases, labels.grid, interval_s);
  study::write_text(folder / "labels.txt", formats::itk_snap_labels());
  study::write_text(folder / "labels.ctbl", formats::slicer_colour_table());
  if (content.cine) {
    study::write_images(folder / "cine.nii.gz", content.cine->phases, content.cine->grid,
                        interval_s);
  }
}

int export_atlas(const ExportArguments& arguments) {
  const fs::path source(arguments.source);
  const bool slicer = arguments.to == "slicer";
  std::error_code ignored;
  const bool study = fs::is_directory(source, ignored);
  if (slicer != arguments.phase.has_value()) {
    throw Error(ErrorCode::Usage, slicer ? "--to slicer: name a phase with --phase"
                                         : "--phase is for --to slicer alone");
  }
  if (slicer && !study) {
    throw_invalid(arguments.source + " is no study; a package cannot be corrected, its study can");
  }
  set_thread_count(arguments.common.threads);
  Console console(arguments.common.verbose);
  console.stage("export", [&](StageContext& context) {
    // What was painted over an export, or an exam's own images, must not be lost to another one.
    study::NewFiles files(arguments.output);
    if (slicer) {
      export_for_editor(source, *arguments.phase, files.place());
    } else {
      const Content content =
          study ? from_study(source, arguments.to) : from_package(source, arguments.to);
      if (arguments.to == "nifti") export_images(content, files.place(), context);
      if (arguments.to == "vdb") export_vdb(content, files.place(), context);
      if (arguments.to == "obj") export_obj(content, files.place());
      if (arguments.to == "glb") export_glb(content, files.place());
    }
    files.put();
  });
  console.finish();
  return 0;
}

}  // namespace

void add_export(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command = app.add_subcommand("export", "Write a package or study in other formats");
  command->footer(
      "nifti: labels.nii.gz, 4-D on the source's grid (1 RV blood, 2 LV myocardium, 3 LV blood,\n"
      "4 the rest of the heart, 5 LA blood, 6 RA blood, 7 aorta; in labels that come back 255 is\n"
      "unknown), from a study or a package of the scene full or anatomy; cine.nii.gz on the same\n"
      "grid, of a package what lies around the heart and stands out of the noise; labels.txt and\n"
      "labels.ctbl, the labels' names and colours for ITK-SNAP and 3D Slicer.\n"
      "glb: heart.glb, glTF 2.0 that beats in any viewer: metres, +y the patient's head, +z the\n"
      "front; a node and material a structure, a morph target a phase.\n"
      "slicer: image_NN, labels_NN (.nii.gz), seeds_NN.mrk.json and these tables, of a phase of a\n"
      "study, to be corrected in an editor of label images, such as 3D Slicer; see\n"
      "docs/correction.md.\n"
      "obj: <structure>_<phase>.obj, workspace [mm], one connectivity.\n"
      "vdb: <structure>.vdb, a float grid <structure>_<phase> a phase: signed distance [mm], "
      "placed\n"
      "in the workspace [mm]; atria and the aorta have distances in a study alone.\n"
      "A file that is there is never replaced by another.");
  command->add_option("PACKAGE|STUDY", arguments->source, "A package, or the folder of a study")
      ->required();
  command->add_option("--to", arguments->to, "Format")
      ->required()
      ->check(CLI::IsMember({"glb", "obj", "vdb", "nifti", "slicer"}));
  command->add_option("--phase", arguments->phase, "Phase of --to slicer, from 0")
      ->check(CLI::Range(0, study::kLastPhase));
  command->add_option("-o,--output", arguments->output, "The folder to write to")
      ->required()
      ->type_name("DIR");
  add_common(*command, arguments->common);
  command->callback([arguments, &run] { run = [arguments] { return export_atlas(*arguments); }; });
}

}  // namespace beatlas::cli
