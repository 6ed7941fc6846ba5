#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/recipe_text.h"

namespace beatlas::cli {

void add_defaults(CLI::App& app, Run& run) {
  struct Arguments {
    std::string recipe;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "defaults", "Print every option with its unit, range and default, as a recipe");
  command
      ->add_option("--recipe", arguments->recipe,
                   "Check this recipe and print it with what it leaves out filled in")
      ->type_name("R.json");
  command->add_flag("--json", arguments->json, "As JSON without comments");
  command->callback([arguments, &run] {
    run = [arguments] {
      const build::Recipe recipe = recipe_of(arguments->recipe);
      print_data(arguments->json ? build::recipe_to_json(recipe).dump(2) + "\n"
                                 : commented_recipe(recipe));
      return 0;
    };
  });
}

}  // namespace beatlas::cli
