#pragma once
/// --prior: the model that tells what voxels are likely to be before labels grow. Where neither the
/// command nor the recipe names one, the environment's BEATLAS_PRIOR does for all exams, in the
/// same words.

#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace beatlas::cli {

/// Adds --prior, whose word stands for /segment/prior of the recipe.
void add_prior_word(CLI::App& command, std::optional<std::string>& word);

/// Takes BEATLAS_PRIOR for this process.
void take_prior_of_environment();

}  // namespace beatlas::cli
