#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/seeds.h"

namespace beatlas::cli {

void add_segment(CLI::App& app, Run& run) {
  struct Arguments {
    StageArguments stage;
    std::string seeds;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("segment", "Find the heart's structures in the study's images");
  command->footer("Look at pictures/overlay.png and pictures/volumes.svg in the study afterwards.");
  add_stage_arguments(*command, arguments->stage);
  command->add_option("--seeds", arguments->seeds, "Places marked by hand; without: automatic")
      ->type_name("S.json");
  command->callback([arguments, &run] {
    run = [arguments] {
      std::vector<segment::Seed> seeds;
      if (!arguments->seeds.empty()) seeds = read_seeds(arguments->seeds);
      return run_stage(arguments->stage, study::Stage::Import, [&](Chain& chain) {
        (void)chain.segment(study::read_exam(chain.study().folder()), seeds);
      });
    };
  });
}

}  // namespace beatlas::cli
