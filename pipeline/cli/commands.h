#pragma once
/// One function a command: it adds the command's words to the parser and, if the command is the
/// one that was called, sets `run`.

#include <functional>
#include <memory>
#include <string>

#include "pipeline/cli/chain.h"

namespace CLI {
class App;
}

namespace beatlas::cli {

/// What to do; its value is the exit code. @throws Error
using Run = std::function<int()>;

void add_build(CLI::App& app, Run& run);
void add_import(CLI::App& app, Run& run);
void add_segment(CLI::App& app, Run& run);
void add_register(CLI::App& app, Run& run);
void add_field(CLI::App& app, Run& run);
void add_mesh(CLI::App& app, Run& run);
void add_pack(CLI::App& app, Run& run);
void add_phantom(CLI::App& app, Run& run);
void add_info(CLI::App& app, Run& run);
void add_validate(CLI::App& app, Run& run);
void add_export(CLI::App& app, Run& run);
void add_defaults(CLI::App& app, Run& run);

/// Words of the commands that take long.
struct CommonArguments {
  int threads = 0;
  bool verbose = false;
  std::string recipe;
  std::string timing;
};
/// Adds --threads and --verbose.
void add_common(CLI::App& command, CommonArguments& arguments);
/// The same with --recipe and --timing.
void add_building(CLI::App& command, CommonArguments& arguments);

/// Adds `--study DIR`, required, and the words of add_building.
struct StageArguments {
  CommonArguments common;
  std::string study;
};
void add_stage_arguments(CLI::App& command, StageArguments& arguments);

/// Opens the study and runs `body` with a chain whose recipe is --recipe's, else the study's, else
/// the defaults. `before` is the last stage that must have run.
int run_stage(const StageArguments& arguments, study::Stage before,
              const std::function<void(Chain&)>& body);

/// The recipe of a new build: that of the file, or the defaults without one.
[[nodiscard]] Recipe recipe_of(const std::string& file);

}  // namespace beatlas::cli
