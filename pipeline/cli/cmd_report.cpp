#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"

namespace beatlas::cli {

void add_report(CLI::App& app, Run& run) {
  struct Arguments {
    CommonArguments common;
    std::string study;
    std::string output;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "report", "Write a page that tells whether a study is good, and what to correct");
  command->footer(
      "One HTML file that needs no network: verdict and reasons, volumes beside normal ranges,\n"
      "outlines on every slice, the beating surface, places to look at with the commands that\n"
      "correct them. 'build' writes it as report.html into the study, with report.json for\n"
      "programs beside it.");
  command->add_option("STUDY", arguments->study, "The study's folder")->required();
  command
      ->add_option("-o,--output", arguments->output,
                   "The page; report.html in the study if not said")
      ->type_name("X.html");
  add_json_lines(*command, arguments->common.json,
                 "Print what report.json holds too, see report.schema.json; progress as JSON lines "
                 "on stderr");
  add_common(*command, arguments->common);
  command->callback([arguments, &run] {
    run = [arguments] {
      if (!arguments->output.empty()) study::check_writable(arguments->output);
      set_thread_count(arguments->common.threads);
      Console console(arguments->common.verbose);
      study::Study study = study_to_write(arguments->study, console, true);
      Orders orders = orders_of(study);
      Chain chain(console, std::move(orders), std::move(study));
      const nlohmann::json summary = chain.report(arguments->output, true);
      if (arguments->common.json) print_data(summary.dump(2) + "\n");
      console.finish();
      return 0;
    };
  });
}

}  // namespace beatlas::cli
