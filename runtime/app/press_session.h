#pragma once
#include <iosfwd>
#include <string>

#include "runtime/app/press.h"

namespace beatlas::app {

/// What the command line says of a scripted press.
struct PressArguments {
  std::string folder;      ///< where to write
  std::string package;     ///< an atlas whose left ventricle the circulation is scaled to; or none
  std::string parameters;  ///< JSON after schemas/palpation.schema.json; or none
  std::string preset;      ///< instead of them; or none
  PressScript script;
  std::string segment;            ///< by name, instead of the script's; or none
  double heart_rate_per_min = 0;  ///< > 0: instead of the atlas's or the parameters'
  bool json = false;              ///< report as JSON
};

/// Runs the press, writes its files and reports to `out`.
/// @throws Error{InvalidInput} naming file and JSON path, or the package that has no volumes of a
/// left ventricle; Error{Machine} if a file cannot be written.
void run_press_session(const PressArguments& arguments, std::ostream& out);

}  // namespace beatlas::app
