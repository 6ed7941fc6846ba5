#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"

namespace beatlas::cli {

void add_defaults(CLI::App& app, Run& run) {
  auto recipe = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("defaults", "Print every option with its default as a recipe");
  command->footer("Keep what you want to change:  beatlas defaults > recipe.json");
  command
      ->add_option("--recipe", *recipe,
                   "Check this recipe and print it with what it leaves out filled in")
      ->type_name("R.json");
  command->callback([recipe, &run] {
    run = [recipe] {
      print_data(recipe_to_json(recipe_of(*recipe)).dump(2) + "\n");
      return 0;
    };
  });
}

}  // namespace beatlas::cli
