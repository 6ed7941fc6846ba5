#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/structural_checks.h"
#include "pipeline/core/parallel.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace {

struct Arguments {
  CommonArguments common;
  std::string package;
  bool json = false;
};

int validate(const Arguments& arguments) {
  set_thread_count(arguments.common.threads);
  Console console(arguments.common.verbose);
  bool passed = false;
  std::string told;
  console.stage("validate", [&](StageContext& context) {
    const atlas::Atlas package = atlas::Atlas::open(
        arguments.package,
        atlas::everything_in(atlas::Atlas::open(arguments.package, {}).manifest()));
    const std::vector<Check> checks = check_structure(package, {}, context);
    passed = all_passed(checks);
    told = arguments.json ? checks_to_json(checks).dump(2) + "\n" : checks_to_text(checks);
  });
  print_data(told);
  console.finish();
  return passed ? 0 : static_cast<int>(ErrorCode::Quality);
}

}  // namespace

void add_validate(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("validate", "Check a package");
  command->add_option("PACKAGE", arguments->package, "The package")->required();
  command->add_flag("--json", arguments->json, "As JSON");
  add_common(*command, arguments->common);
  command->callback([arguments, &run] { run = [arguments] { return validate(*arguments); }; });
}

}  // namespace beatlas::cli
