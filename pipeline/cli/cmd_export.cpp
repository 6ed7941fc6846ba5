#include <array>
#include <cstdio>

#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/source_labels.h"
#include "pipeline/cli/study_status.h"
#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"
#include "pipeline/study/images.h"
#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

struct Arguments {
  CommonArguments common;
  std::string source;
  std::string to;
  std::string output;
};

/// What an export needs, whether it comes from a package or from a study.
struct Content {
  std::vector<std::shared_ptr<const atlas::FieldPayload>> fields;
  std::vector<std::shared_ptr<const atlas::SurfacePayload>> surfaces;
  Grid source;
  Affine workspace_from_lps = Affine::Identity();
  double rr_interval_s = 0;
  std::optional<ImageCycle<float>> cine;
};

Content from_package(const fs::path& file, bool fields) {
  const atlas::Manifest manifest = atlas::Atlas::open(file, {}).manifest();
  atlas::Needs needs;
  for (const atlas::StructureEntry& entry : manifest.structures) {
    const auto structure = structure_from_name(entry.name);
    if (structure) (fields ? needs.fields : needs.surfaces).insert(*structure);
  }
  const atlas::Atlas package = atlas::Atlas::open(file, needs);
  Content content;
  for (Structure structure : needs.fields) content.fields.push_back(package.field(structure));
  for (Structure structure : needs.surfaces) content.surfaces.push_back(package.surface(structure));
  content.source = {manifest.source_size, manifest.source_lps_from_index};
  content.workspace_from_lps = manifest.workspace_from_lps;
  content.rr_interval_s = manifest.rr_interval_s;
  return content;
}

void require_done(const study::Study& study, study::Stage stage) {
  for (const StageStatus& status : status_of(study).stages) {
    if (status.stage > stage || status.stage == study::Stage::Pictures) continue;
    if (status.state == "done" || status.state == "edited") continue;
    throw_invalid("in the study " + study.folder().string() + " the stage " +
                  std::string(study::stage_name(status.stage)) + " is " + status.state +
                  "; build it first: beatlas build --study " + study.folder().string() +
                  " -o X.beatlas");
  }
}

Content from_study(const fs::path& folder, bool fields) {
  const study::Study study = study::Study::open(folder);
  Content content;
  require_done(study, fields ? study::Stage::Field : study::Stage::Mesh);
  if (!fields) {
    for (SurfaceCycle& cycle : study::read_surfaces(folder)) {
      content.surfaces.push_back(std::make_shared<atlas::SurfacePayload>(atlas::SurfacePayload{
          cycle.structure, std::move(cycle.triangles), std::move(cycle.positions)}));
    }
    return content;
  }
  const Recipe recipe = orders_of(study).recipe;
  for (const FieldCycle& cycle : study::read_fields(folder)) {
    content.fields.push_back(
        std::make_shared<atlas::FieldPayload>(pack::stored_field(cycle, recipe.pack)));
  }
  Exam exam = study::read_exam(folder);
  content.source = exam.stack.grid();
  content.rr_interval_s = exam.stack.rr_interval_s;
  content.cine = std::move(exam.stack.images);
  content.workspace_from_lps = study::read_workspace_from_lps(folder);
  return content;
}

void write_obj(const fs::path& file, const atlas::SurfacePayload& surface, std::size_t phase) {
  std::string text = "# " + std::string(structure_name(surface.structure)) + ", workspace [mm]\n";
  std::array<char, 96> line{};
  for (const Vec3f& vertex : surface.positions[phase]) {
    std::snprintf(line.data(), line.size(), "v %.9g %.9g %.9g\n", static_cast<double>(vertex[0]),
                  static_cast<double>(vertex[1]), static_cast<double>(vertex[2]));
    text += line.data();
  }
  for (const auto& [a, b, c] : surface.triangles) {
    text += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " +
            std::to_string(c + 1) + "\n";
  }
  study::write_text(file, text);
}

void export_surfaces(const Content& content, const fs::path& folder) {
  for (const auto& surface : content.surfaces) {
    for (std::size_t phase = 0; phase < surface->positions.size(); ++phase) {
      std::array<char, 80> name{};
      std::snprintf(name.data(), name.size(), "%s_%03zu.obj",
                    structure_name(surface->structure).data(), phase);
      write_obj(folder / name.data(), *surface, phase);
    }
  }
}

void export_images(const Content& content, const fs::path& folder, StageContext& context) {
  if (content.source.count() == 0) {
    throw_invalid("this atlas was not made from images, so there is no grid for labels");
  }
  const LabelCycle labels = labels_from_fields(
      content.fields, content.source, content.workspace_from_lps, content.rr_interval_s, context);
  const double interval_s = content.rr_interval_s / labels.phase_count();
  study::write_labels(folder / "labels.nii.gz", labels, labels.grid, interval_s);
  if (content.cine) {
    study::write_images(folder / "cine.nii.gz", *content.cine, content.cine->grid, interval_s);
  }
}

int export_atlas(const Arguments& arguments) {
  const fs::path source(arguments.source);
  const bool images = arguments.to == "nifti";
  set_thread_count(arguments.common.threads);
  Console console(arguments.common.verbose);
  console.stage("export", [&](StageContext& context) {
    std::error_code ignored;
    const Content content = fs::is_directory(source, ignored) ? from_study(source, images)
                                                              : from_package(source, images);
    study::make_folder(arguments.output);
    if (images) {
      export_images(content, arguments.output, context);
    } else {
      export_surfaces(content, arguments.output);
    }
  });
  console.finish();
  return 0;
}

}  // namespace

void add_export(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("export", "Write a package or study in other formats");
  command->footer(
      "nifti: labels.nii.gz, 4-D on the source's grid (1 RV blood, 2 LV myocardium, 3 LV blood,\n"
      "4 the rest of the heart), from a package of the scene full or from a study; from a study\n"
      "also cine.nii.gz.\n"
      "obj: <structure>_<phase>.obj, workspace [mm], one connectivity.");
  command->add_option("PACKAGE|STUDY", arguments->source, "A package, or the folder of a study")
      ->required();
  command->add_option("--to", arguments->to, "Format")
      ->required()
      ->check(CLI::IsMember({"nifti", "obj"}));
  command->add_option("-o,--output", arguments->output, "The folder to write to")
      ->required()
      ->type_name("DIR");
  add_common(*command, arguments->common);
  command->callback([arguments, &run] { run = [arguments] { return export_atlas(*arguments); }; });
}

}  // namespace beatlas::cli
