#include "runtime/app/case_command.h"

#include <array>
#include <ostream>
#include <utility>

#include <CLI/CLI.hpp>

#include "runtime/app/case_files.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"

namespace beatlas::app {
namespace {

std::string none_found(const CasesArguments& arguments, std::size_t looked_at) {
  if (looked_at == 0) return arguments.folder + " holds no case that can be read (NAME.case.json)";
  std::string words;
  for (const std::string& word : arguments.words) words += (words.empty() ? "" : ", ") + word;
  return "none of " + std::to_string(looked_at) + " cases in " + arguments.folder + " has " + words;
}

void check_nothing_told_twice(const PlayArguments& arguments) {
  const PressArguments& press = arguments.press;
  const std::array<std::pair<bool, const char*>, 7> told{
      {{arguments.model_named, "--model"},
       {arguments.published, "--published"},
       {!arguments.inside.empty(), "--inside"},
       {!press.preset.empty(), "--preset"},
       {!press.parameters.empty(), "--parameters"},
       {arguments.heart_rate_per_min > 0, "--heart-rate"},
       {!arguments.exercise.empty(), "--exercise"}}};
  for (const auto& [is_told, name] : told) {
    if (!is_told) continue;
    throw Error(ErrorCode::Usage,
                "--case tells by itself which muscle is felt, how and at what heart rate; leave " +
                    std::string(name) + " out");
  }
}

}  // namespace

CLI::App* add_cases(CLI::App& app, CasesArguments& arguments) {
  CLI::App& cases =
      *app.add_subcommand("cases", "search a folder of cases: hearts, and what was felt on them");
  cases.add_option("FOLDER", arguments.folder, "of NAME.case.json files")->required();
  cases.add_option("WORDS", arguments.words, "that a case must have, all of them");
  cases.add_flag("--json", arguments.json, "list as JSON");
  cases.footer("Example:\n  beatlas-play cases samples/cases anterior soft");
  return &cases;
}

int run_cases(const CasesArguments& arguments, std::ostream& out, std::ostream& err) {
  const Cases cases = read_cases(arguments.folder);
  std::vector<std::pair<const Case*, AtlasState>> found;
  for (const Case& entry : cases.read) {
    if (matches(entry, arguments.words)) found.emplace_back(&entry, atlas_state(entry));
  }
  if (arguments.json) {
    nlohmann::json list = nlohmann::json::array();
    for (const auto& [entry, state] : found) {
      list.push_back({{"file", entry->file.string()},
                      {"atlas_state", atlas_state_name(state)},
                      {"case", case_to_json(*entry)}});
    }
    out << json_text(nlohmann::json{{"cases", std::move(list)}}, 2) << '\n';
  } else {
    for (const auto& [entry, state] : found) out << case_line(*entry, state) << '\n';
    if (found.size() == 1) out << case_text(*found.front().first);
    if (found.empty()) out << none_found(arguments, cases.read.size()) << '\n';
  }
  for (const std::string& trouble : cases.troubles) err << "beatlas-play: " << trouble << '\n';
  return cases.troubles.empty() ? 0 : static_cast<int>(ErrorCode::InvalidInput);
}

PlayArguments take_case(PlayArguments arguments) {
  if (arguments.case_file.empty()) return arguments;
  check_nothing_told_twice(arguments);
  const Case taken = read_case(arguments.case_file);
  if (arguments.package.empty() && !taken.atlas.empty()) {
    const AtlasState state = atlas_state(taken);
    const std::string atlas = taken.atlas_path().string();
    if (state == AtlasState::Missing) {
      throw_invalid(arguments.case_file + ": /atlas: " + atlas +
                    " cannot be read; put it there, or name a PACKAGE beside --case");
    }
    if (state == AtlasState::Other) {
      throw_invalid(arguments.case_file + ": /atlas_sha256 is not that of " + atlas +
                    "; get the atlas that was felt, or name a PACKAGE beside --case");
    }
    arguments.package = atlas;
  }
  arguments.model = "patch";
  arguments.press.preset = taken.preset;
  arguments.press.parameters = taken.parameters_path().string();
  arguments.heart_rate_per_min = taken.heart_rate_per_min;
  return arguments;
}

}  // namespace beatlas::app
