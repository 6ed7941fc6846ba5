#include <CLI/CLI.hpp>

#include "pipeline/build/learned_prior.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/named_files.h"
#include "pipeline/cli/progress.h"
#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {

void add_json_lines(CLI::App& command, bool& json, const std::string& description) {
  command.add_flag("--json", json, description)->each([](const std::string&) { speak_json(); });
}

void add_common(CLI::App& command, CommonArguments& arguments) {
  command
      .add_option("--threads", arguments.threads,
                  "Threads to use; 0 = all cores. Changes speed, never the result")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command.add_flag("-v,--verbose", arguments.verbose,
                   "Log lines also where stderr is no terminal, and times and memory at the end");
  if (command.get_option_no_throw("--json") == nullptr) {
    add_json_lines(command, arguments.json,
                   "Progress, messages and the end as JSON lines on stderr, for other programs; "
                   "see progress.schema.json");
  }
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
  add_discard_edits(command, arguments.discard_edits);
  add_building(command, arguments.common);
}

void add_discard_edits(CLI::App& command, bool& discard_edits) {
  command.add_flag(
      "--discard-edits", discard_edits,
      "Make anew what was edited by hand in the study, and with the images of another exam give up "
      "its seeds and labels, too; without, all is kept");
}

study::Study study_to_write(const std::string& folder, Console& console, bool must_be_there) {
  const study::Waiting waiting{
      [&] { console.tell("another beatlas writes in " + folder + "; waiting for its end"); },
      cancel_flag()};
  return must_be_there ? study::Study::open_to_write(folder, waiting)
                       : study::Study::create(folder, waiting);
}

build::Recipe recipe_of(const std::string& file) {
  return file.empty() ? build::Recipe{} : build::read_recipe(file);
}

build::Recipe recipe_for_study(const std::string& file, const build::Recipe& before,
                               Console& console) {
  build::Recipe out = build::read_recipe_for_exam(file, before);
  std::string replaced;
  for (const std::string& option : build::replaced_of_exam(before, out)) {
    replaced += (replaced.empty() ? "" : ", ") + option;
  }
  if (!replaced.empty()) {
    console.warn(file + " replaces what this study was last built with: " + replaced +
                 "; leave out of it what is to stay");
  }
  return out;
}

int run_stage(const StageArguments& arguments, study::Stage before,
              const std::function<void(build::IncrementalBuild&)>& body,
              const std::function<void(build::Orders&)>& change) {
  refuse_to_replace(arguments.common.timing, OutputKind::Timing, arguments.study);
  set_thread_count(arguments.common.threads);
  Console console(arguments.common.verbose);
  study::Study study = study_to_write(arguments.study, console, true);
  build::Orders orders = build::orders_of(study);
  if (!arguments.common.recipe.empty()) {
    orders.recipe = recipe_for_study(arguments.common.recipe, orders.recipe, console);
  }
  if (change) change(orders);
  build::note_prior(orders, &study);
  orders.discard_edits = arguments.discard_edits;
  build::keep_orders(orders, study);
  if (!arguments.common.timing.empty()) study::check_writable(arguments.common.timing);
  build::IncrementalBuild stages(console, std::move(orders), std::move(study));
  for (const study::Stage stage : study::kAllStages) {
    if (stage <= before && stage != study::Stage::Pictures) stages.require(stage);
  }
  body(stages);
  stages.finish();
  console.finish();
  if (!arguments.common.timing.empty()) {
    console.write_timing(arguments.common.timing, arguments.common.threads);
  }
  return 0;
}

}  // namespace beatlas::cli
