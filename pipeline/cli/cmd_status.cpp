#include <CLI/CLI.hpp>

#include "pipeline/build/study_status.h"
#include "pipeline/cli/commands.h"
#include "pipeline/study/study.h"

namespace beatlas::cli {

void add_status(CLI::App& app, Run& run) {
  struct Arguments {
    std::string study;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("status", "Tell which stages of a study are done, stale or edited");
  command->footer(
      "done      as 'build' would make it\n"
      "edited    changed by hand; kept until --discard-edits\n"
      "stale     what it was made from has changed; runs again\n"
      "running   is being made now by another beatlas\n"
      "stopped   was interrupted while it wrote; runs again\n"
      "open      has not run\n"
      "refused   gave less than the recipe demands: no package was made of it; says why\n"
      "waits     done, but a stage before it will run again\n"
      "A change of the source is seen by 'build SOURCE', not here.");
  command->add_option("STUDY", arguments->study, "The study's folder")->required();
  command->add_flag("--json", arguments->json, "As JSON, see status.schema.json");
  command->callback([arguments, &run] {
    run = [arguments] {
      const build::StudyStatus status = build::status_of(study::Study::open(arguments->study));
      print_data(arguments->json ? to_json(status).dump(2) + "\n" : to_text(status));
      return 0;
    };
  });
}

}  // namespace beatlas::cli
