#pragma once
/// What a network has learned, for one exam: the model that the recipe names, else the usual one.

#include <optional>
#include <string>

#include "pipeline/build/corrections.h"
#include "pipeline/build/orders.h"
#include "pipeline/prior/prior.h"

namespace beatlas::build {

/// In the options of the stage `segment`: the model's SHA-256, or "none".
inline constexpr auto kPriorOption = "prior";

/// The model of this process for exams whose recipe names none, in the words of a recipe: a file,
/// none, or empty, the built-in one, as it is before this is called. Not while a build runs.
void set_usual_prior(std::string word);

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

}  // namespace beatlas::build
