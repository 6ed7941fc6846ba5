#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"

namespace beatlas::cli {

void add_mesh(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<StageArguments>();
  CLI::App* command =
      app.add_subcommand("mesh", "Make surfaces of the cycle from the study's fields");
  add_stage_arguments(*command, *arguments);
  command->callback([arguments, &run] {
    run = [arguments] {
      return run_stage(*arguments, study::Stage::Field,
                       [](build::IncrementalBuild& stages) { stages.surfaces(); });
    };
  });
}

}  // namespace beatlas::cli
