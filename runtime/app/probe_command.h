#pragma once
/// `beatlas-play probe`: its words, and what it does.

#include <iosfwd>
#include <string>

namespace CLI {
class App;
}

namespace beatlas::app {

struct ProbeArguments {
  std::string package;
  std::string points;
  std::string output;
  std::string structure = "heart";
  std::string frame = "workspace";
};

/// @return the subcommand
CLI::App* add_probe(CLI::App& app, ProbeArguments& arguments);

/// @param in what the points are read from if they are "-"  @param out where they go without
/// --output
/// @throws Error{Usage} for an unknown structure; as Atlas::open, probe and write_file
void run_probe(const ProbeArguments& arguments, std::istream& in, std::ostream& out);

}  // namespace beatlas::app
