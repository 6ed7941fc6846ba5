#pragma once

namespace CLI {
class App;
}

namespace beatlas::cli {

/// Completes the --help of every command of the program: the synopsis names the options that are
/// required, and behind what the command says itself stand an example and the papers whose methods
/// it uses, if it uses any. Call when all commands were added; a command of which help.cpp knows no
/// example keeps its help, and a test fails.
void complete_help(CLI::App& app);

}  // namespace beatlas::cli
