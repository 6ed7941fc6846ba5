#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/named_files.h"
#include "runtime/atlas/atlas.h"
#include "runtime/atlas/info.h"

namespace beatlas::cli {

void add_info(CLI::App& app, Run& run) {
  struct Arguments {
    std::string package;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("info", "Tell what is in a package");
  command->add_option("PACKAGE", arguments->package, "The package")->required();
  command->add_flag("--json", arguments->json, "As JSON");
  command->callback([arguments, &run] {
    run = [arguments] {
      refuse_what_is_no_package(arguments->package);
      const atlas::Atlas package = atlas::Atlas::open(arguments->package, {});
      print_data(arguments->json ? atlas::info_json(package.manifest()).dump(2) + "\n"
                                 : atlas::info_text(package.manifest()));
      return 0;
    };
  });
}

}  // namespace beatlas::cli
