#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {

void add_common(CLI::App& command, CommonArguments& arguments) {
  command
      .add_option("--threads", arguments.threads,
                  "Threads to use; 0 = all cores. Changes speed, never the result")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command.add_flag("-v,--verbose", arguments.verbose,
                   "Log lines also where stderr is no terminal, and times and memory at the end");
}

void add_building(CLI::App& command, CommonArguments& arguments) {
  command
      .add_option("--recipe", arguments.recipe,
                  "Options of the stages, JSON; see 'beatlas defaults'")
      ->type_name("R.json");
  command
      .add_option("--timing", arguments.timing,
                  "Write wall and CPU time of each stage and the peak memory to this file")
      ->type_name("FILE.json");
  add_common(command, arguments);
}

void add_stage_arguments(CLI::App& command, StageArguments& arguments) {
  command.add_option("--study", arguments.study, "The study's folder")
      ->required()
      ->type_name("DIR");
  add_building(command, arguments.common);
}

Recipe recipe_of(const std::string& file) { return file.empty() ? Recipe{} : read_recipe(file); }

int run_stage(const StageArguments& arguments, study::Stage before,
              const std::function<void(Chain&)>& body) {
  study::Study study = study::Study::open(arguments.study);
  Recipe recipe;
  if (!arguments.common.recipe.empty()) {
    recipe = read_recipe(arguments.common.recipe);
    study.set_recipe(recipe_to_json(recipe));
  } else if (study.recipe()) {
    try {
      recipe = recipe_from_json(*study.recipe());
    } catch (const Error& error) {
      throw error.with_context(arguments.study + "/study.json: /recipe");
    }
  }
  if (!arguments.common.timing.empty()) study::check_writable(arguments.common.timing);
  set_thread_count(arguments.common.threads);
  Console console(arguments.common.verbose);
  Chain chain(console, recipe, std::move(study));
  chain.recall(before);
  body(chain);
  console.finish();
  if (!arguments.common.timing.empty()) {
    console.write_timing(arguments.common.timing, arguments.common.threads);
  }
  return 0;
}

}  // namespace beatlas::cli
