#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"

namespace beatlas::cli {

void add_field(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<StageArguments>();
  CLI::App* command =
      app.add_subcommand("field", "Make signed distance fields of the study's structures");
  add_stage_arguments(*command, *arguments);
  command->callback([arguments, &run] {
    run = [arguments] {
      return run_stage(*arguments, study::Stage::Register,
                       [](build::IncrementalBuild& stages) { stages.fields(); });
    };
  });
}

}  // namespace beatlas::cli
