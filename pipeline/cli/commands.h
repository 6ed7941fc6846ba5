#pragma once
/// One function a command: it adds the command's words to the parser and, if the command is the
/// one that was called, sets `run`.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/build/incremental_build.h"
#include "pipeline/cli/console.h"

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
void add_report(CLI::App& app, Run& run);
void add_assess(CLI::App& app, Run& run);
void add_status(CLI::App& app, Run& run);
void add_bench(CLI::App& app, Run& run);
void add_identify(CLI::App& app, Run& run);
void add_elastogram(CLI::App& app, Run& run);
void add_seeds(CLI::App& app, Run& run);

/// Words of the commands that take long.
struct CommonArguments {
  int threads = 0;
  bool verbose = false;
  bool json = false;
  std::string recipe;
  std::string timing;
};
/// Adds --threads and --verbose, and --json unless the command has added it.
void add_common(CLI::App& command, CommonArguments& arguments);
/// Adds --json, which has the command speak JSON on stderr.
void add_json_lines(CLI::App& command, bool& json, const std::string& description);
/// The same with --recipe and --timing.
void add_building(CLI::App& command, CommonArguments& arguments);

/// Adds `--study DIR`, required, --discard-edits and the words of add_building.
struct StageArguments {
  CommonArguments common;
  std::string study;
  bool discard_edits = false;
};
void add_stage_arguments(CLI::App& command, StageArguments& arguments);

void add_discard_edits(CLI::App& command, bool& discard_edits);

/// Opens or starts the study to write, saying so if it must wait for another program.
[[nodiscard]] study::Study study_to_write(const std::string& folder, Console& console,
                                          bool must_be_there);

/// Opens the study and runs `body` with a build of it whose recipe is --recipe's, else the study's.
/// `before` is the last stage that must be up to date.
/// @param change called with the orders of the study before they are used; may be empty
int run_stage(const StageArguments& arguments, study::Stage before,
              const std::function<void(build::IncrementalBuild&)>& body,
              const std::function<void(build::Orders&)>& change = {});

/// The recipe of a new build: that of the file, or the defaults without one.
[[nodiscard]] build::Recipe recipe_of(const std::string& file);
/// That of a study which was built with `before`: see build::recipe_for_exam. Says what of the exam
/// the file replaces.
[[nodiscard]] build::Recipe recipe_for_study(const std::string& file, const build::Recipe& before,
                                             Console& console);

}  // namespace beatlas::cli
