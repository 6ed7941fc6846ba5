#pragma once
/// `beatlas-play cases` and `beatlas-play --case`: their words, and what they do.

#include <iosfwd>
#include <string>
#include <vector>

#include "runtime/app/play_options.h"

namespace CLI {
class App;
}

namespace beatlas::app {

struct CasesArguments {
  std::string folder;
  std::vector<std::string> words;
  bool json = false;
};

/// @return the subcommand
CLI::App* add_cases(CLI::App& app, CasesArguments& arguments);

/// Lists the cases of a folder that match the words; of one alone also all that was felt.
/// @param err a line for each file that cannot be read; the others are listed
/// @return the exit code: 0, also if nothing matches, and that of InvalidInput if a file could not
/// be read  @throws Error{InvalidInput} if the folder cannot be read
[[nodiscard]] int run_cases(const CasesArguments& arguments, std::ostream& out, std::ostream& err);

/// What a call with --case stands for: with the case's atlas as its package, unless one is named,
/// and paper B's muscle as the case has it. Without --case as it is.
/// @throws Error{Usage} if the call itself tells what the case does, or wants what no case is felt
/// by; Error{InvalidInput} as read_case, or if the case's atlas is not there or has another SHA-256
[[nodiscard]] PlayArguments take_case(PlayArguments arguments);

}  // namespace beatlas::app
