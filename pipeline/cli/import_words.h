#pragma once
#include <optional>
#include <string>
#include <vector>

#include "pipeline/build/recipe.h"
#include "pipeline/cli/console.h"
#include "pipeline/ingest/ingest.h"

namespace CLI {
class App;
}

namespace beatlas::cli {

/// What `build` and `import` are told of the source; each overrides the recipe.
struct ImportWords {
  std::optional<double> rr_interval_s;
  std::string times;  ///< "0,0.04,..." or the name of a file with such numbers; empty: not given
  std::optional<int> phases;
  std::optional<int> exam;
  std::optional<int> stack;
  std::vector<std::string> series;  ///< numbers, or "all" alone; empty: not given
};

/// Adds --rr, --times, --phases, --exam, --series, --stack; to be called when the command has its
/// SOURCE, which may not be empty either.
void add_import_words(CLI::App& command, ImportWords& words);

/// @throws Error{Usage} for times that are no ascending numbers; Error{InvalidInput} for their file
void apply(const ImportWords& words, ingest::IngestOptions& options);

/// Warns of what the import takes as the study's last did, because neither `words` nor the recipe
/// replaces it.
/// @param named the recipe alone, or the defaults without one; @param taken with what was kept
void warn_of_kept(const ImportWords& words, const build::Recipe& named, const build::Recipe& taken,
                  Console& console);

/// Numbers parted by commas, semicolons or white space. @throws Error{Usage} naming `what`.
[[nodiscard]] std::vector<double> parse_times(const std::string& text, const std::string& what);

}  // namespace beatlas::cli
