#include <utility>

#include <CLI/CLI.hpp>

#include "pipeline/build/learned_prior.h"
#include "pipeline/build/made_package.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/correction_words.h"
#include "pipeline/cli/import_words.h"
#include "pipeline/cli/named_files.h"
#include "pipeline/cli/prior_words.h"
#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

struct BuildArguments {
  CommonArguments common;
  std::vector<std::string> sources;
  ImportWords words;
  std::string output;
  std::string scene;  ///< empty: full, or that of the package that is written again
  CorrectionWords corrections;
  std::optional<std::string> prior;
  std::string study;
  bool discard_edits = false;
  bool no_report = false;
  bool self_test = false;
};

void check_named(const BuildArguments& arguments) {
  if (arguments.sources.empty() && arguments.study.empty()) {
    throw Error(ErrorCode::Usage, "SOURCE is missing: name the images, or a study with --study");
  }
  if (arguments.output.empty() && arguments.study.empty()) {
    throw Error(ErrorCode::Usage, "-o is missing: name the package to write");
  }
  const CorrectionWords& made = arguments.corrections;
  if (made.labels_aligned && !made.labels.empty() && !arguments.sources.empty()) {
    throw Error(
        ErrorCode::Usage,
        "--labels-aligned tells of labels that were drawn on a study's own images; name the "
        "study with --study, and no images beside it");
  }
}

struct PackageToWrite {
  build::Scene scene;
  fs::path file;
};

/// Without -o it is the package that the study made last, for the same scene.
PackageToWrite package_to_write(const BuildArguments& arguments) {
  PackageToWrite out;
  if (!arguments.scene.empty()) out.scene = build::read_scene(arguments.scene);
  out.file = arguments.output;
  if (out.file.empty()) {
    const study::Study made = study::Study::open(arguments.study);
    out.file = build::made_package(made);
    if (arguments.scene.empty()) out.scene = build::made_scene(made);
  }
  study::check_writable(out.file);
  return out;
}

/// What recipe, corrections and prior on the command line order.
build::Orders orders_named(const BuildArguments& arguments) {
  build::Orders orders;
  if (!arguments.common.recipe.empty()) orders.recipe = build::read_recipe(arguments.common.recipe);
  take_corrections(arguments.corrections, orders);
  if (arguments.prior) orders.recipe.segment.prior = *arguments.prior;
  if (arguments.prior || !arguments.common.recipe.empty()) build::check_prior(orders.recipe);
  return orders;
}

/// What the command line does not name stays as the study was last built with.
void keep_unnamed(const BuildArguments& arguments, build::Orders before, build::Orders& orders,
                  Console& console) {
  const std::string& recipe = arguments.common.recipe;
  const build::Recipe named = std::exchange(
      orders.recipe,
      recipe.empty() ? before.recipe : recipe_for_study(recipe, before.recipe, console));
  if (!arguments.sources.empty()) {
    warn_of_kept(arguments.words, named, orders.recipe, console);
  }
  if (arguments.corrections.seeds.empty()) {
    orders.seeds = std::move(before.seeds);
    orders.painted = std::move(before.painted);
    orders.seeds_from = std::move(before.seeds_from);
    orders.keeps_seeds = before.keeps_seeds;
  }
  if (arguments.corrections.labels.empty()) {
    orders.labels = std::move(before.labels);
    orders.labels_from = std::move(before.labels_from);
    orders.keeps_labels = before.keeps_labels;
    if (arguments.corrections.coverage.empty()) {
      orders.coverage = std::move(before.coverage);
      orders.coverage_from = std::move(before.coverage_from);
    }
  } else if (arguments.sources.empty()) {
    take_back_alignment(arguments.study, arguments.corrections, before, orders);
    keep_other_phases(arguments.study, before, orders);
  } else if (before.labels && orders.labels && !orders.labels->phases.empty()) {
    console.warn(
        "labels that were given before are given up: images are named, too; give all in one file");
  }
}

/// A package that is refused for its quality leaves the report all the same.
void make_or_report(build::IncrementalBuild& stages, const PackageToWrite& package,
                    bool with_report, Console& console) {
  try {
    stages.make(package.scene, package.file);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::Quality && with_report) {
      try {
        (void)stages.report({}, true);
      } catch (const std::exception& trouble) {  // the refusal is what the user must hear of
        console.warn(std::string("the report was not written: ") + trouble.what());
      }
    }
    throw;
  }
}

/// An exam that allows no self-test is warned of: the atlas stands all the same.
void self_test_or_warn(build::IncrementalBuild& stages, Console& console) {
  try {
    (void)stages.self_test();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::InvalidInput) throw;
    console.warn(std::string("no self-test: ") + error.what());
  }
}

int build(const BuildArguments& arguments) {
  check_named(arguments);
  refuse_to_replace(arguments.output, OutputKind::Package, arguments.study);
  refuse_to_replace(arguments.common.timing, OutputKind::Timing, arguments.study);
  const PackageToWrite package = package_to_write(arguments);
  if (!arguments.common.timing.empty()) study::check_writable(arguments.common.timing);
  // Bad words are told before a study is waited for or made.
  build::Orders orders = orders_named(arguments);
  set_thread_count(arguments.common.threads);
  Console console(arguments.common.verbose);
  std::optional<study::Study> study;
  if (!arguments.study.empty()) {
    study = study_to_write(arguments.study, console, arguments.sources.empty());
    keep_unnamed(arguments, build::orders_of(*study), orders, console);
  }
  apply(arguments.words, orders.recipe.import);
  if (arguments.prior) orders.recipe.segment.prior = *arguments.prior;
  build::note_prior(orders, study ? &*study : nullptr);
  build::check_prior(orders, study ? &*study : nullptr);
  orders.discard_edits = arguments.discard_edits;
  if (study) build::keep_orders(orders, *study);
  const bool with_report = study.has_value() && !arguments.no_report;
  build::IncrementalBuild stages(console, std::move(orders), std::move(study));
  stages.import({arguments.sources.begin(), arguments.sources.end()});
  make_or_report(stages, package, with_report, console);
  if (arguments.self_test) self_test_or_warn(stages, console);
  if (with_report) (void)stages.report({}, false);
  stages.finish();
  console.finish();
  if (!arguments.common.timing.empty()) {
    console.write_timing(arguments.common.timing, arguments.common.threads);
  }
  return 0;
}

}  // namespace

void add_build(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<BuildArguments>();
  CLI::App* command = app.add_subcommand("build", "Build an atlas from the images of an exam");
  command->footer(
      "SOURCE is a DICOM folder (a whole exam, mixed series are fine), one 4-D NIfTI, NRRD or\n"
      "MetaImage file, or 3-D ones in the order of their phases.\n"
      "An existing package is replaced at once, when the new one is complete.");
  command->add_option("SOURCE", arguments->sources,
                      "Images; may be left out where --study has been built before");
  add_import_words(*command, arguments->words);
  command
      ->add_option("-o,--output", arguments->output,
                   "The package to write; may be left out where the one that the study made last "
                   "still lies in it, beside it or in the current folder: it is written again")
      ->type_name("X.beatlas");
  command->add_option("--scene", arguments->scene,
                      "What the package is for: palpation, anatomy, full or a JSON file (default: "
                      "full; without -o what it was for)");
  add_correction_words(*command, arguments->corrections);
  add_prior_word(*command, arguments->prior);
  command
      ->add_option("--study", arguments->study,
                   "Leave what each stage gives in this folder, in formats that can be opened and "
                   "corrected elsewhere, with pictures to check by eye; built again, only what "
                   "changed runs")
      ->type_name("DIR");
  add_discard_edits(*command, arguments->discard_edits);
  command->add_flag("--no-report", arguments->no_report,
                    "Leave report.html and report.json out of the study");
  command
      ->add_flag("--self-test", arguments->self_test,
                 "Measure how well slices and phases foretell each other, for the study's report; "
                 "see 'beatlas assess'")
      ->needs("--study");
  add_building(*command, arguments->common);
  command->callback([arguments, &run] { run = [arguments] { return build(*arguments); }; });
}

}  // namespace beatlas::cli
