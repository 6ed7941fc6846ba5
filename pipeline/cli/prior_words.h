#pragma once
/// --prior: the model that tells what voxels are likely to be before labels grow. Where neither the
/// command nor the recipe names one, the environment's BEATLAS_PRIOR does for all exams, in the
/// same words.

#include <optional>
#include <string>

#include "pipeline/cli/correction_words.h"
#include "pipeline/cli/orders.h"
#include "pipeline/prior/prior.h"

namespace CLI {
class App;
}

namespace beatlas::cli {

/// In the options of the stage `segment`: the model's SHA-256, or "none".
inline constexpr auto kPriorOption = "prior";

/// Adds --prior, whose word stands for /segment/prior of the recipe.
void add_prior_word(CLI::App& command, std::optional<std::string>& word);

/// Sets Orders::prior_sha256 from the recipe: empty if the model is not at hand. A study that was
/// made with the model that the recipe names still tells of it then. @param study may be null
void note_prior(Orders& orders, const study::Study* study);

/// Loads the model that a recipe names, if any, before long work.
/// @throws as prior::Model::load, prior::default_model_path
void check_prior(const Recipe& recipe);
/// The same, unless the study holds a segmentation that was made with it.
void check_prior(const Orders& orders, const study::Study* study);

/// The prior of an exam, of the model that the recipe names; nothing without one.
[[nodiscard]] std::optional<prior::PriorCycle> prior_of(const Exam& exam, const Recipe& recipe,
                                                        StageContext context);
/// Whether it is of use: labels of every phase in which nothing is left unknown tell all.
[[nodiscard]] bool wants_prior(const Corrections& corrections, const Recipe& recipe, int phases);

}  // namespace beatlas::cli
