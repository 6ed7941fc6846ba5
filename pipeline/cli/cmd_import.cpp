#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/import_words.h"
#include "pipeline/cli/key_surfaces.h"
#include "pipeline/cli/named_files.h"
#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace {

struct ImportArguments {
  StageArguments stage;
  std::vector<std::string> sources;
  std::string surfaces;
  ImportWords words;
};

// Images and labels of key surfaces; the labels stay the study's, for the stage segment.
std::pair<Exam, std::vector<std::filesystem::path>> exam_of_surfaces(const std::string& file,
                                                                     build::Orders& orders,
                                                                     Console& console) {
  KeySurfaces keys = read_key_surfaces(file);
  keyframes::SeenHeart seen;
  console.stage("surfaces", [&](StageContext& context) {
    try {
      seen = keyframes::see_heart(keys.heart, context);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::InvalidInput) throw;
      throw error.with_context(file);
    }
  });
  study::GivenLabels labels{.images = std::move(seen.labels),
                            .phases = {},
                            .file_sha256 = study::sha256_of_file(keys.files.front()),
                            .sha256 = {}};
  labels.sha256 = study::given_sha256(labels.images, labels.phases);
  orders.labels = std::move(labels);
  orders.labels_from = "the key surfaces";
  orders.keeps_labels = false;
  orders.coverage.clear();
  return {std::move(seen.exam), std::move(keys.files)};
}

int import_exam(const ImportArguments& arguments) {
  const CommonArguments& common = arguments.stage.common;
  if (arguments.sources.empty() == arguments.surfaces.empty()) {
    throw Error(ErrorCode::Usage, "name either the images, SOURCE, or --surfaces FILE.json");
  }
  refuse_to_replace(common.timing, OutputKind::Timing, arguments.stage.study);
  Console console(common.verbose);
  study::Study study = study_to_write(arguments.stage.study, console, false);
  build::Orders orders = build::orders_of(study);
  const build::Recipe named = recipe_of(common.recipe);
  if (!common.recipe.empty()) {
    orders.recipe = recipe_for_study(common.recipe, orders.recipe, console);
  }
  warn_of_kept(arguments.words, named, orders.recipe, console);
  apply(arguments.words, orders.recipe.import);
  orders.discard_edits = arguments.stage.discard_edits;
  if (!common.timing.empty()) study::check_writable(common.timing);
  set_thread_count(common.threads);
  std::optional<std::pair<Exam, std::vector<std::filesystem::path>>> made;
  if (!arguments.surfaces.empty()) made = exam_of_surfaces(arguments.surfaces, orders, console);
  build::keep_orders(orders, study);
  build::IncrementalBuild stages(console, std::move(orders), std::move(study));
  if (made) {
    stages.import_made(std::move(made->first), made->second);
  } else {
    stages.import({arguments.sources.begin(), arguments.sources.end()});
  }
  stages.finish();
  console.finish();
  if (!common.timing.empty()) console.write_timing(common.timing, common.threads);
  return 0;
}

}  // namespace

void add_import(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<ImportArguments>();
  CLI::App* command =
      app.add_subcommand("import", "Start a study: read the images of an exam into it");
  command->footer(
      "SOURCE: as for 'beatlas build'.\n"
      "The recipe is kept in the study; later stages use it unless they are given another.");
  command->add_option("SOURCE", arguments->sources, "Images");
  command
      ->add_option(
          "--surfaces", arguments->surfaces,
          "Closed key surfaces (PLY, OBJ, STL) instead of images, as a JSON file tells of "
          "them (schemas/surfaces.schema.json); 'beatlas build --study DIR -o X.beatlas' goes on")
      ->type_name("FILE.json");
  add_import_words(*command, arguments->words);
  add_stage_arguments(*command, arguments->stage);
  command->callback([arguments, &run] { run = [arguments] { return import_exam(*arguments); }; });
}

}  // namespace beatlas::cli
