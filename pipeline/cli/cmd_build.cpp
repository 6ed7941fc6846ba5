#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/seeds.h"
#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

struct Arguments {
  CommonArguments common;
  std::vector<std::string> sources;
  std::string output;
  std::string scene = "full";
  std::string seeds;
  std::string study;
};

int build(const Arguments& arguments) {
  const Recipe recipe = recipe_of(arguments.common.recipe);
  const Scene scene = read_scene(arguments.scene);
  std::vector<segment::Seed> seeds;
  if (!arguments.seeds.empty()) seeds = read_seeds(arguments.seeds);
  study::check_writable(arguments.output);
  if (!arguments.common.timing.empty()) study::check_writable(arguments.common.timing);
  std::optional<study::Study> study;
  if (!arguments.study.empty()) {
    study = study::Study::create(arguments.study);
    study->set_recipe(recipe_to_json(recipe));
  }
  // A study keeps the surfaces too, so that it can be packed again for another scene.
  const bool with_surfaces = study.has_value() || scene_has_surfaces(scene);
  set_thread_count(arguments.common.threads);
  Console console(arguments.common.verbose);
  Chain chain(console, recipe, std::move(study));

  std::vector<ShapeCycle> shapes;
  {
    const Exam exam = chain.import({arguments.sources.begin(), arguments.sources.end()});
    const Segmentation segmentation = [&] {
      try {
        return chain.segment(exam, seeds);
      } catch (const Error& error) {
        throw error.with_context(arguments.sources.front());
      }
    }();
    shapes = chain.registration(exam, segmentation).shapes;
  }
  const std::vector<FieldCycle> fields = chain.fields(shapes);
  shapes.clear();
  std::vector<SurfaceCycle> surfaces;
  if (with_surfaces) surfaces = chain.surfaces(fields);
  chain.pack(fields, std::move(surfaces), scene, arguments.output);

  console.finish();
  if (!arguments.common.timing.empty()) {
    console.write_timing(arguments.common.timing, arguments.common.threads);
  }
  return 0;
}

}  // namespace

void add_build(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("build", "Build an atlas from the images of an exam");
  command->footer(
      "SOURCE is a DICOM folder (a whole exam, mixed series are fine) or one 4-D NIfTI file.\n"
      "An existing package is replaced at once, when the new one is complete.\n"
      "Example: beatlas build exam/ -o heart.beatlas --scene palpation");
  command->add_option("SOURCE", arguments->sources, "Images")->required();
  command->add_option("-o,--output", arguments->output, "The package to write")
      ->required()
      ->type_name("X.beatlas");
  command
      ->add_option("--scene", arguments->scene,
                   "What the package is for: palpation, anatomy, full or a JSON file")
      ->capture_default_str();
  command->add_option("--seeds", arguments->seeds, "Places marked by hand; without: automatic")
      ->type_name("S.json");
  command
      ->add_option("--study", arguments->study,
                   "Leave what each stage gives in this folder, in formats that can be opened "
                   "elsewhere, with pictures to check by eye")
      ->type_name("DIR");
  add_building(*command, arguments->common);
  command->callback([arguments, &run] { run = [arguments] { return build(*arguments); }; });
}

}  // namespace beatlas::cli
