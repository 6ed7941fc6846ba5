#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/import_words.h"
#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"

namespace beatlas::cli {
namespace {

struct Arguments {
  StageArguments stage;
  std::vector<std::string> sources;
  ImportWords words;
};

int import_exam(const Arguments& arguments) {
  const CommonArguments& common = arguments.stage.common;
  Console console(common.verbose);
  study::Study study = study_to_write(arguments.stage.study, console, false);
  Orders orders = orders_of(study);
  if (common.recipe.empty()) {
    warn_of_kept(arguments.words, orders.recipe.import, console);
  } else {
    orders.recipe = read_recipe(common.recipe);
  }
  apply(arguments.words, orders.recipe.import);
  orders.discard_edits = arguments.stage.discard_edits;
  keep_orders(orders, study);
  if (!common.timing.empty()) study::check_writable(common.timing);
  set_thread_count(common.threads);
  Chain chain(console, std::move(orders), std::move(study));
  chain.import({arguments.sources.begin(), arguments.sources.end()});
  chain.tell_kept();
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
      "SOURCE: as for 'beatlas build'.\n"
      "The recipe is kept in the study; later stages use it unless they are given another.\n"
      "Example: beatlas import exam/ --study study/");
  command->add_option("SOURCE", arguments->sources, "Images")->required();
  add_import_words(*command, arguments->words);
  add_stage_arguments(*command, arguments->stage);
  command->callback([arguments, &run] { run = [arguments] { return import_exam(*arguments); }; });
}

}  // namespace beatlas::cli
