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

/// Words that every long command understands.
struct CommonArguments {
  int threads = 0;
  bool verbose = false;
  std::string recipe;
  std::string timing;
};
void add_common(CLI::App& command, CommonArguments& arguments, bool with_recipe = true);

/// Adds `--study DIR`, required, and the common words.
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
