#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/named_files.h"
#include "pipeline/study/files.h"

namespace beatlas::cli {

void add_pack(CLI::App& app, Run& run) {
  struct Arguments {
    StageArguments stage;
    std::string output;
    std::string scene = "full";
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("pack", "Write the package of a study");
  command->footer("An existing package is replaced at once, when the new one is complete.");
  add_stage_arguments(*command, arguments->stage);
  command
      ->add_option("-o,--output", arguments->output,
                   "The package to write; without: heart.beatlas in the study")
      ->type_name("X.beatlas");
  command
      ->add_option("--scene", arguments->scene,
                   "What the package is for: palpation, anatomy, full or a JSON file")
      ->capture_default_str();
  command->callback([arguments, &run] {
    run = [arguments] {
      const build::Scene scene = build::read_scene(arguments->scene);
      const std::filesystem::path file =
          arguments->output.empty()
              ? std::filesystem::path(arguments->stage.study) / "heart.beatlas"
              : std::filesystem::path(arguments->output);
      refuse_to_replace(arguments->output, OutputKind::Package, arguments->stage.study);
      if (!arguments->output.empty()) study::check_writable(file);
      return run_stage(arguments->stage, study::Stage::Mesh,
                       [&](build::IncrementalBuild& stages) { stages.pack(scene, file); });
    };
  });
}

}  // namespace beatlas::cli
