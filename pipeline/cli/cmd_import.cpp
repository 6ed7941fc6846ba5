#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"

namespace beatlas::cli {
namespace {

struct Arguments {
  StageArguments stage;
  std::vector<std::string> sources;
};

int import_exam(const Arguments& arguments) {
  const CommonArguments& common = arguments.stage.common;
  const Recipe recipe = recipe_of(common.recipe);
  if (!common.timing.empty()) study::check_writable(common.timing);
  study::Study study = study::Study::create(arguments.stage.study);
  study.set_recipe(recipe_to_json(recipe));
  set_thread_count(common.threads);
  Console console(common.verbose);
  Chain chain(console, recipe, std::move(study));
  (void)chain.import({arguments.sources.begin(), arguments.sources.end()});
  console.finish();
  if (!common.timing.empty()) console.write_timing(common.timing, common.threads);
  return 0;
}

}  // namespace

void add_import(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("import", "Start a study: read the images of an exam into it");
  command->footer(
      "The recipe is kept in the study; later stages use it unless they are given another.\n"
      "Example: beatlas import exam/ --study study/");
  command->add_option("SOURCE", arguments->sources, "Images")->required();
  add_stage_arguments(*command, arguments->stage);
  command->callback([arguments, &run] { run = [arguments] { return import_exam(*arguments); }; });
}

}  // namespace beatlas::cli
