#pragma once
/// A recipe to be read by people.

#include <string>
#include <string_view>

#include "pipeline/build/recipe.h"

namespace beatlas::cli {

/// schemas/recipe.schema.json as it was when the program was built.
[[nodiscard]] std::string_view recipe_schema();

/// The recipe as JSON with a line of comment above every option: what it is, its unit and range,
/// and its default where the recipe has another value. read_recipe reads it back.
[[nodiscard]] std::string commented_recipe(const build::Recipe& recipe);

}  // namespace beatlas::cli
