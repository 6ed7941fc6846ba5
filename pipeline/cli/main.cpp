#include <cstdio>
#include <exception>
#include <new>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <malloc.h>

#include "pipeline/build/version.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/console.h"
#include "pipeline/cli/help.h"
#include "pipeline/cli/prior_words.h"
#include "pipeline/cli/progress.h"
#include "runtime/base/error.h"
#include "runtime/base/nearest_name.h"

namespace {

int exit_code(beatlas::ErrorCode code) { return static_cast<int>(code); }

int fail(const char* message, beatlas::ErrorCode code) {
  if (beatlas::cli::speaks_json()) {
    beatlas::cli::say_end(exit_code(code), message);
    return exit_code(code);
  }
  std::fprintf(stderr, "beatlas: %s\n", beatlas::cli::one_line(message).c_str());
  return exit_code(code);
}

/// What the first word that looks like an option of the command but is none was meant to be, as the
/// end of a sentence; empty if there is none, or none is near.
std::string meant_option(const CLI::App& app, int argc, char** argv) {
  std::set<std::string> names;
  for (const CLI::App* command = &app; command != nullptr;) {
    for (const CLI::Option* option : command->get_options()) {
      for (const std::string& name : option->get_lnames()) names.insert("--" + name);
    }
    const std::vector<CLI::App*> chosen = command->get_subcommands();
    command = chosen.empty() ? nullptr : chosen.front();
  }
  for (int at = 2; at < argc; ++at) {
    const std::string_view whole = argv[at];
    const std::string word(whole.substr(0, whole.find('=')));
    if (!word.starts_with("--") || names.count(word) != 0) continue;
    const std::string meant = beatlas::nearest_name(word, names);
    if (meant.empty()) return "";
    return std::string("; by ").append(word).append(", did you mean ").append(meant).append("?");
  }
  return "";
}

/// Says that a word which stands where a command should, of the program or of a command that has
/// its own, is none; empty if there is no such word. The parser would only say that one is missing.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  const CLI::App& within = chosen.empty() ? app : *chosen.front();
  std::set<std::string> names;
  for (const CLI::App* command : within.get_subcommands({})) names.insert(command->get_name());
  // What the command is about comes before its own commands.
  std::ptrdiff_t at = chosen.empty() ? 1 : 2;
  for (const CLI::Option* option : within.get_options()) at += option->get_positional() ? 1 : 0;
  if (names.empty() || !within.get_subcommands().empty() || at >= argc || argv[at][0] == '-') {
    return "";
  }
  const std::string word = argv[at];
  const std::string meant = beatlas::nearest_name(word, names);
  return "there is no command '" + (chosen.empty() ? "" : within.get_name() + " ") + word + "'" +
         (meant.empty() ? "" : "; did you mean " + meant + "?");
}

/// Images of megabytes come and go by the thousand. Handed back to the system and taken anew each
/// time, their pages would cost a tenth of all time.
void keep_freed_memory() {
  constexpr int kLargest = 32 << 20;  // that the C library lets a threshold be
  mallopt(M_MMAP_THRESHOLD, kLargest);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
}

int run_command(int argc, char** argv) {
  using namespace beatlas::cli;
  CLI::App app("From ECG-gated cardiac MRI to a beating heart that can be touched.", "beatlas");
  app.set_version_flag("--version", std::string("beatlas ") + beatlas::build::kVersion);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 2 usage, 3 bad input, 4 quality below demand, 5 machine trouble.");
  Run run;
  add_build(app, run);
  add_import(app, run);
  add_segment(app, run);
  add_register(app, run);
  add_field(app, run);
  add_mesh(app, run);
  add_pack(app, run);
  add_phantom(app, run);
  add_info(app, run);
  add_validate(app, run);
  add_bench(app, run);
  add_export(app, run);
  add_report(app, run);
  add_assess(app, run);
  add_status(app, run);
  add_seeds(app, run);
  add_identify(app, run);
  add_elastogram(app, run);
  add_defaults(app, run);
  complete_help(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // help and version
    const std::string unknown = unknown_command(app, argc, argv);
    const std::string told =
        unknown.empty() ? error.what() + meant_option(app, argc, argv) : unknown;
    const std::string command =
        app.get_subcommands().empty() ? "" : " " + app.get_subcommands().front()->get_name();
    return fail((told + "; see: beatlas" + command + " --help").c_str(), beatlas::ErrorCode::Usage);
  }
  catch_interrupts();
  take_prior_of_environment();
  const int code = run();
  if (speaks_json()) say_end(code, "");
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  try {
    return run_command(argc, argv);
  } catch (const beatlas::Error& error) {
    // Wherever it was met, and whatever was said of it on the way up.
    if (*beatlas::cli::cancel_flag()) {
      return fail("stopped on request; nothing half written was left", beatlas::ErrorCode::Machine);
    }
    return fail(error.what(), error.code());
  } catch (const std::bad_alloc&) {
    return fail("not enough memory; close other programs or use coarser options",
                beatlas::ErrorCode::Machine);
  } catch (const std::exception& error) {
    return fail((std::string("unexpected trouble: ") + error.what()).c_str(),
                beatlas::ErrorCode::Machine);
  }
}
