#include <filesystem>
#include <system_error>

#include <CLI/CLI.hpp>

#include "pipeline/build/report_facts.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/named_files.h"
#include "pipeline/cli/package_report.h"
#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {

void add_report(CLI::App& app, Run& run) {
  struct Arguments {
    CommonArguments common;
    std::string source;
    std::string output;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "report",
      "Write a page that tells whether an atlas is good, and what to correct in its study");
  command->footer(
      "One HTML file that needs no network: verdict and reasons, volumes beside normal ranges,\n"
      "outlines on every slice, the beating surface, places to look at with the commands that\n"
      "correct them. 'build' writes it as report.html into the study, with report.json for\n"
      "programs beside it. Of a package alone it tells what the package holds and what its maker\n"
      "told; leaks, boundaries that are hardly seen and commands that correct are the study's.");
  command
      ->add_option("PACKAGE|STUDY", arguments->source,
                   "A package, or the folder of the study that it was made from")
      ->required();
  command
      ->add_option("-o,--output", arguments->output,
                   "The page; of a study report.html in it if not said")
      ->type_name("X.html");
  add_json_lines(*command, arguments->common.json,
                 "Print what report.json holds too, see report.schema.json; progress as JSON lines "
                 "on stderr");
  add_common(*command, arguments->common);
  command->callback([arguments, &run] {
    run = [arguments] {
      std::error_code ignored;
      const bool package = std::filesystem::is_regular_file(arguments->source, ignored);
      if (package) {
        refuse_what_is_no_package(arguments->source);
        if (arguments->output.empty()) {
          throw Error(ErrorCode::Usage, "-o is missing: name the page of the package's report");
        }
      }
      refuse_to_replace(arguments->output, OutputKind::Page, arguments->source);
      if (!arguments->output.empty()) study::check_writable(arguments->output);
      set_thread_count(arguments->common.threads);
      Console console(arguments->common.verbose);
      if (package) {
        nlohmann::json summary;
        console.stage("report", [&](StageContext& context) {
          summary = report_package(arguments->source, arguments->output, context);
        });
        console.tell(build::told_report(summary, arguments->output));
        if (arguments->common.json) print_data(summary.dump(2) + "\n");
        console.finish();
        return 0;
      }
      study::Study study = study_to_write(arguments->source, console, true);
      build::Orders orders = build::orders_of(study);
      build::IncrementalBuild stages(console, std::move(orders), std::move(study));
      const nlohmann::json summary = stages.report(arguments->output, true);
      if (arguments->common.json) print_data(summary.dump(2) + "\n");
      console.finish();
      return 0;
    };
  });
}

}  // namespace beatlas::cli
