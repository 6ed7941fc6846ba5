#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include <CLI/CLI.hpp>

#include "pipeline/assess/structural_checks.h"
#include "pipeline/assess/validate.h"
#include "pipeline/cli/commands.h"
#include "pipeline/core/parallel.h"
#include "pipeline/phantom/truth.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

struct Arguments {
  CommonArguments common;
  std::string package;
  std::string truth;
  bool json = false;
  assess::ValidateLimits limits;
};

struct Outcome {
  std::string told;
  bool passed = false;
};

/// Means and worst values over the phases of each structure.
std::string report_to_text(const assess::ValidationReport& report) {
  std::string text =
      "structure       Dice, least   mean mm   p95 mm   "
      "Hausdorff mm   bias mm   volume error ml\n";
  for (const assess::StructureErrors& entry : report.structures) {
    double dice = 1, mean = 0, p95 = 0, hausdorff = 0, bias = 0, volume = 0;
    for (const assess::PhaseErrors& phase : entry.phases) {
      const double share = 1.0 / static_cast<double>(entry.phases.size());
      dice = std::min(dice, phase.dice);
      mean += share * phase.mean_mm;
      bias += share * phase.bias_mm;
      p95 = std::max(p95, phase.p95_mm);
      hausdorff = std::max(hausdorff, phase.hausdorff_mm);
      if (std::abs(phase.volume_error_ml) > std::abs(volume)) volume = phase.volume_error_ml;
    }
    char line[160];
    std::snprintf(line, sizeof line, "%-15s %11.4f %9.3f %8.3f %14.3f %+9.3f %+17.2f\n",
                  structure_name(entry.structure).data(), dice, mean, p95, hausdorff, bias, volume);
    text += line;
  }
  text += "mean and bias are means over the phases, the others the worst phase\n";
  for (const std::string& failure : report.failures) text += "FAILED " + failure + "\n";
  return text + (report.passed ? "passed\n" : "not passed\n");
}

phantom::Phantom read_truth(const fs::path& truth) {
  std::error_code ignored;
  const fs::path file = fs::is_directory(truth, ignored) ? truth / "truth.json" : truth;
  const nlohmann::json content = study::read_json(file);
  try {
    return phantom::phantom_from_truth(content);
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

Outcome against_truth(const Arguments& arguments, StageContext& context) {
  const phantom::Phantom truth = read_truth(arguments.truth);
  atlas::Needs needs = atlas::everything_in(atlas::Atlas::open(arguments.package, {}).manifest());
  needs.surfaces.clear();
  const assess::ValidationReport report = assess::validate(
      atlas::Atlas::open(arguments.package, needs), truth, arguments.limits, context);
  return {arguments.json ? assess::report_to_json(report).dump(2) + "\n" : report_to_text(report),
          report.passed};
}

Outcome without_truth(const Arguments& arguments, StageContext& context) {
  const atlas::Atlas package = atlas::Atlas::open(
      arguments.package,
      atlas::everything_in(atlas::Atlas::open(arguments.package, {}).manifest()));
  const std::vector<assess::Check> checks = assess::check_structure(package, {}, context);
  return {arguments.json ? assess::checks_to_json(checks).dump(2) + "\n" : assess::checks_to_text(checks),
          assess::all_passed(checks)};
}

int validate(const Arguments& arguments) {
  set_thread_count(arguments.common.threads);
  Console console(arguments.common.verbose);
  Outcome outcome;
  console.stage("validate", [&](StageContext& context) {
    outcome = arguments.truth.empty() ? without_truth(arguments, context)
                                      : against_truth(arguments, context);
  });
  print_data(outcome.told);
  console.finish();
  return outcome.passed ? 0 : static_cast<int>(ErrorCode::Quality);
}

void add_limits(CLI::App& command, assess::ValidateLimits& limits) {
  const auto add = [&](const char* name, std::optional<double>& value, const char* help) {
    command.add_option(name, value, help)
        ->check(CLI::NonNegativeNumber)
        ->needs("--truth")
        ->group("Limits; a phase of a structure beyond one does not pass");
  };
  add("--min-dice", limits.min_dice, "Dice, 0 to 1");
  add("--max-mean-mm", limits.max_mean_mm, "Mean distance of the surfaces");
  add("--max-p95-mm", limits.max_p95_mm, "95th percentile of the distance");
  add("--max-hausdorff-mm", limits.max_hausdorff_mm, "Largest distance");
  add("--max-bias-mm", limits.max_bias_mm, "Signed mean distance, magnitude");
  add("--max-volume-error-ml", limits.max_volume_error_ml, "Error of the volume, magnitude");
}

}  // namespace

void add_validate(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("validate", "Check a package, by itself or against a phantom's truth");
  command->footer(
      "Without --truth: hashes, closed surfaces, volumes and "
      "surfaces that agree with the fields.\n"
      "With it: errors of every structure in every phase. Exit "
      "code 4 if it does not pass.");
  command->add_option("PACKAGE", arguments->package, "The package")->required();
  command->add_option("--truth", arguments->truth, "The folder that 'beatlas phantom' wrote")
      ->type_name("DIR");
  command->add_flag("--json", arguments->json, "As JSON");
  add_limits(*command, arguments->limits);
  add_common(*command, arguments->common);
  command->callback([arguments, &run] { run = [arguments] { return validate(*arguments); }; });
}

}  // namespace beatlas::cli
