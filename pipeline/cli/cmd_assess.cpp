#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/self_test_text.h"
#include "pipeline/core/parallel.h"

namespace beatlas::cli {

void add_assess(CLI::App& app, Run& run) {
  struct Arguments {
    CommonArguments common;
    std::string study;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "assess", "Measure on this patient how well slices and phases foretell each other");
  command->footer(
      "Every other slice is hidden and foretold by the others, as the atlas is made; so is every\n"
      "phase, up to twelve. What is foretold is compared with the slice's own contours, in\n"
      "mm along the surface's normal, more than 6 mm as 6: no expert and no truth is asked.\n"
      "Slices foretell here over twice their distance, so the atlas lies closer between them:\n"
      "of a smooth wall the error falls with the square of the distance. Whether the contours\n"
      "themselves are right it does not tell; the report does. The study keeps the figures for\n"
      "its report, in self_test.json, as long as its labels are those. 'build --self-test' does\n"
      "the same after a build.");
  command->add_option("STUDY", arguments->study, "The study's folder")->required();
  add_json_lines(*command, arguments->common.json,
                 "Print it as JSON, see assess.schema.json; progress as JSON lines on stderr");
  add_common(*command, arguments->common);
  command->callback([arguments, &run] {
    run = [arguments] {
      set_thread_count(arguments->common.threads);
      Console console(arguments->common.verbose);
      study::Study study = study_to_write(arguments->study, console, true);
      build::Orders orders = build::orders_of(study);
      build::IncrementalBuild stages(console, std::move(orders), std::move(study));
      stages.require(study::Stage::Import);
      stages.require(study::Stage::Segment);
      const assess::SelfTest found = stages.self_test();
      print_data(arguments->common.json ? to_json(found).dump(2) + "\n" : self_test_to_text(found));
      console.finish();
      return 0;
    };
  });
}

}  // namespace beatlas::cli
