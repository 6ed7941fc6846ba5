#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <variant>

#include <CLI/CLI.hpp>

#include "pipeline/assess/structural_checks.h"
#include "pipeline/assess/validate.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/named_files.h"
#include "pipeline/cli/validation_text.h"
#include "pipeline/core/parallel.h"
#include "pipeline/phantom/drawn_truth.h"
#include "pipeline/phantom/truth.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"
#include "runtime/base/replace_file.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

struct ValidateArguments {
  CommonArguments common;
  std::string package;
  std::string truth;
  std::string recipe;
  std::string force_structure;  // empty: the heart
  std::string promises;         // empty: not said
  std::string vertices;         // empty: not asked
  assess::Limits limits;        // said on the command line
};

constexpr const char* kNoPromises = "none";

struct Outcome {
  std::string told;
  bool passed = false;
};

using Truth = std::variant<phantom::Phantom, phantom::DrawnTruth>;

Truth read_truth(const fs::path& truth) {
  std::error_code ignored;
  const fs::path file = fs::is_directory(truth, ignored) ? truth / "truth.json" : truth;
  const nlohmann::json content = study::read_json(file);
  try {
    if (phantom::is_drawn_truth(content)) return phantom::DrawnTruth(content);
    return phantom::phantom_from_truth(content);
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

/// Those of the recipe; a limit said on the command line replaces it for every structure.
assess::LimitSet limits_of(const ValidateArguments& arguments) {
  assess::LimitSet limits = recipe_of(arguments.recipe).validate;
  for (const assess::LimitName& limit : assess::kLimitNames) {
    const std::optional<double>& said = arguments.limits.*limit.member;
    if (!said) continue;
    limits.all.*limit.member = said;
    for (auto& [structure, own] : limits.structures) (own.*limit.member).reset();
  }
  return limits;
}

bool has_any(const assess::Limits& limits) {
  return std::any_of(
      assess::kLimitNames.begin(), assess::kLimitNames.end(),
      [&](const assess::LimitName& limit) { return (limits.*limit.member).has_value(); });
}

/// Without a word and without limits of one's own a package is held to what is promised of the
/// phantom that it is of, by the name of that. Of others nothing is.
const assess::PromiseSet* promises_of(const ValidateArguments& arguments,
                                      const assess::LimitSet& own, const Truth& truth) {
  if (!arguments.promises.empty()) return assess::promise_set(arguments.promises);
  const bool has_own =
      has_any(own.all) || std::any_of(own.structures.begin(), own.structures.end(),
                                      [](const auto& each) { return has_any(each.second); });
  const auto* phantom = std::get_if<phantom::Phantom>(&truth);
  return has_own || phantom == nullptr ? nullptr : assess::promise_set(phantom->spec().name);
}

/// A draw knows where its surfaces lie and nothing of forces, and nothing is promised of one draw.
void refuse_what_a_draw_lacks(const ValidateArguments& arguments) {
  if (!arguments.force_structure.empty()) {
    throw_invalid("the truth is a drawn exam's, which tells no force: leave --force-structure out");
  }
  if (!arguments.promises.empty() && arguments.promises != kNoPromises) {
    throw_invalid("the truth is a drawn exam's, of which nothing is promised: leave --limits out");
  }
}

Outcome against_truth(const ValidateArguments& arguments, StageContext& context) {
  assess::ValidateOptions options;
  options.limits = limits_of(arguments);
  if (!arguments.force_structure.empty()) {
    options.palpations.structure = *structure_from_name(arguments.force_structure);
    options.demand_force = true;
  }
  const Truth truth = read_truth(arguments.truth);
  if (std::holds_alternative<phantom::DrawnTruth>(truth)) {
    refuse_what_a_draw_lacks(arguments);
  } else if (!arguments.vertices.empty()) {
    throw_invalid("--vertices needs the truth of a drawn exam, and this is none: leave it out");
  }
  if (!arguments.vertices.empty()) refuse_other_kind(arguments.vertices, vertices_to_csv({}));
  options.promises = promises_of(arguments, options.limits, truth);
  atlas::Needs needs = atlas::everything_in(atlas::Atlas::open(arguments.package, {}).manifest());
  const assess::Candidate package =
      assess::candidate_of(atlas::Atlas::open(arguments.package, needs));
  const assess::ValidationReport report = std::visit(
      [&](const auto& of) { return assess::validate(package, of, options, context); }, truth);
  if (!arguments.vertices.empty()) {
    study::write_text(arguments.vertices, vertices_to_csv(report));
  }
  return {arguments.common.json ? assess::report_to_json(report).dump(2) + "\n"
                                : validation_to_text(report),
          report.passed};
}

Outcome without_truth(const ValidateArguments& arguments, StageContext& context) {
  const atlas::Atlas package = atlas::Atlas::open(
      arguments.package,
      atlas::everything_in(atlas::Atlas::open(arguments.package, {}).manifest()));
  const std::vector<assess::Check> checks = assess::check_structure(package, {}, context);
  return {arguments.common.json ? assess::checks_to_json(checks).dump(2) + "\n"
                                : assess::checks_to_text(checks),
          assess::all_passed(checks)};
}

int validate(const ValidateArguments& arguments) {
  refuse_what_is_no_package(arguments.package);
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

void add_limits(CLI::App& command, assess::Limits& limits) {
  for (const assess::LimitName& limit : assess::kLimitNames) {
    std::string option = std::string("--") + limit.name;
    std::replace(option.begin(), option.end(), '_', '-');
    command.add_option(option, limits.*limit.member, limit.help)
        ->check(CLI::Range(0.0, limit.most))
        ->needs("--truth")
        ->group("Limits; a phase of a structure beyond one does not pass");
  }
}

std::vector<std::string> structure_names() {
  std::vector<std::string> out;
  for (const Structure structure : kVentricular) out.emplace_back(structure_name(structure));
  return out;
}

void add_promises(CLI::App& command, std::string& promises) {
  std::vector<std::string> names;
  for (const assess::PromiseSet& set : assess::kPromiseSets) names.emplace_back(set.name);
  names.emplace_back(kNoPromises);
  std::array<char, 400> text{};
  std::snprintf(
      text.data(), text.size(),
      "How strict: %g times what docs/promises.md promises of the phantoms adult, small and "
      "clinical from their images, or from labels, or labels and coverage, of the truth; or none. "
      "If not said: that of the phantom, by its preset, or none beside limits of your own",
      assess::kPromiseMargin);
  command.add_option("--limits", promises, text.data())
      ->check(CLI::IsMember(names))
      ->needs("--truth");
}

}  // namespace

void add_validate(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<ValidateArguments>();
  CLI::App* command =
      app.add_subcommand("validate", "Check a package, by itself or against a phantom's truth");
  command->footer(
      "Without --truth: hashes, content, surfaces, fields, and that they agree.\n"
      "With it: errors of every structure in every phase, and of the force that is felt; held to\n"
      "1.3 times what is promised of phantoms, see --limits. Of a drawn exam, errors of every\n"
      "surface, between slices too.\n"
      "Exit code 4 if it does not pass.");
  command->add_option("PACKAGE", arguments->package, "The package")->required();
  command->add_option("--truth", arguments->truth, "The folder that 'beatlas phantom' wrote")
      ->type_name("DIR");
  add_json_lines(*command, arguments->common.json,
                 "The figures as JSON on stdout; progress as JSON lines on stderr");
  command
      ->add_option("--recipe", arguments->recipe,
                   "Recipe with limits in its section \"validate\"; see 'beatlas defaults'")
      ->type_name("R.json")
      ->needs("--truth");
  command
      ->add_option("--force-structure", arguments->force_structure,
                   "Structure whose force is compared; heart if not said")
      ->check(CLI::IsMember(structure_names()))
      ->needs("--truth");
  command
      ->add_option("--vertices", arguments->vertices,
                   "Write how far each vertex lies off, at end-diastole and end-systole; of a "
                   "drawn exam's truth")
      ->type_name("FILE.csv")
      ->needs("--truth");
  add_promises(*command, arguments->promises);
  add_limits(*command, arguments->limits);
  add_common(*command, arguments->common);
  command->callback([arguments, &run] { run = [arguments] { return validate(*arguments); }; });
}

}  // namespace beatlas::cli
