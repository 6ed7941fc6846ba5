#include <CLI/CLI.hpp>

#include "pipeline/build/learned_prior.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/correction_words.h"
#include "pipeline/cli/prior_words.h"

namespace beatlas::cli {

void add_segment(CLI::App& app, Run& run) {
  struct Arguments {
    StageArguments stage;
    CorrectionWords corrections;
    std::optional<std::string> prior;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("segment", "Find the heart's structures in the study's images");
  command->footer(
      "Look at pictures/overlay.png and pictures/volumes.svg in the study afterwards, "
      "and at pictures/leak_NN.png where a leak alarm rang.");
  add_stage_arguments(*command, arguments->stage);
  add_correction_words(*command, arguments->corrections);
  add_prior_word(*command, arguments->prior);
  command->callback([arguments, &run] {
    run = [arguments] {
      return run_stage(
          arguments->stage, study::Stage::Import,
          [](build::IncrementalBuild& stages) { stages.segment(); },
          [&](build::Orders& orders) {
            const build::Orders before = orders;
            take_corrections(arguments->corrections, orders);
            if (!arguments->corrections.labels.empty()) {
              take_back_alignment(arguments->stage.study, arguments->corrections, before, orders);
              keep_other_phases(arguments->stage.study, before, orders);
            }
            if (!arguments->prior) return;
            orders.recipe.segment.prior = *arguments->prior;
            build::check_prior(orders.recipe);
          });
    };
  });
}

}  // namespace beatlas::cli
