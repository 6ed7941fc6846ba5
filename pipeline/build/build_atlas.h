#pragma once
/// The whole build for a program that has an exam at hand and wants its atlas.

#include <filesystem>

#include "pipeline/build/listener.h"
#include "pipeline/build/recipe.h"
#include "pipeline/build/scene.h"
#include "pipeline/core/exam.h"

namespace beatlas::build {

/// Exam -> the package of a scene, with no study and no correction by hand: `beatlas build` without
/// its words. Atria, surfaces and images that the scene does not show are not made. The same bytes
/// for any number of threads.
/// @param file is replaced when the package is complete, and left alone otherwise
/// @throws Error{InvalidInput} if no heart is found or the recipe's model cannot be read;
/// Error{Quality} below what the recipe demands; Error{Machine} if the listener's context is
/// cancelled or the file cannot be written
void build_atlas(Exam exam, const Recipe& recipe, const Scene& scene,
                 const std::filesystem::path& file, Listener& listener);

}  // namespace beatlas::build
