#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"

namespace beatlas::cli {

void add_register(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<StageArguments>();
  CLI::App* command =
      app.add_subcommand("register", "Put the study's structures into the workspace");
  add_stage_arguments(*command, *arguments);
  command->callback([arguments, &run] {
    run = [arguments] {
      return run_stage(*arguments, study::Stage::Segment, [](Chain& chain) {
        const std::filesystem::path& folder = chain.study().folder();
        for (const std::string& file : chain.study().edited_outputs(study::Stage::Segment)) {
          if (file != "segment/labels.nii.gz") continue;
          chain.console().warn(
              "segment/labels.nii.gz was edited, but shapes are made from "
              "coverage_<structure>.nii.gz: "
              "edit these, or give seeds to 'beatlas segment --seeds'");
        }
        (void)chain.registration(study::read_exam(folder), study::read_segmentation(folder));
      });
    };
  });
}

}  // namespace beatlas::cli
