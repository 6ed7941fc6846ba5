#include <filesystem>

#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/formats/image_file.h"
#include "runtime/atlas/atlas.h"
#include "runtime/atlas/info.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

/// What else a user may have at hand is told by its name, with the command that shows it.
void refuse_what_is_no_package(const fs::path& file) {
  std::error_code ignored;
  const std::string name = file.string();
  if (fs::is_regular_file(file / "study.json", ignored)) {
    throw_invalid(name + " is a study, not a package; 'beatlas status " + name +
                  "' tells what is done, 'beatlas report " + name + "' writes its report");
  }
  if (fs::is_directory(file, ignored)) {
    throw_invalid(name + " is a folder, not a package; if it holds images, 'beatlas import " +
                  name + " --study DIR' tells what they are");
  }
  if (fs::exists(file, ignored) && formats::format_of(file)) {
    throw_invalid(name + " is an image, not a package; 'beatlas import " + name +
                  " --study DIR' tells what it is");
  }
}

}  // namespace

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
