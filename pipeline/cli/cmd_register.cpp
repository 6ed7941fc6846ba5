#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"

namespace beatlas::cli {

void add_register(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<StageArguments>();
  CLI::App* command =
      app.add_subcommand("register", "Put the study's structures into the workspace");
  add_stage_arguments(*command, *arguments);
  command->callback([arguments, &run] {
    run = [arguments] {
      return run_stage(*arguments, study::Stage::Segment,
                       [](build::IncrementalBuild& stages) { stages.registration(); });
    };
  });
}

}  // namespace beatlas::cli
