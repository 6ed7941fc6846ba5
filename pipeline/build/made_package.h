#pragma once
/// The package that a study made last, found again by its bytes: a study remembers no path and no
/// file's name, which may be a patient's.

#include <filesystem>

#include "pipeline/build/scene.h"
#include "pipeline/study/study.h"

namespace beatlas::build {

/// Looks in the study; then in the folder that holds it and in the current one, too.
/// @throws Error{Usage} asking for a name where it has made none, it lies elsewhere, there are
/// copies of it, or it lies beside the study and another study beside it made the same
[[nodiscard]] std::filesystem::path made_package(const study::Study& study);

/// What that package is for. @pre made_package found it  @throws Error{InvalidInput}
[[nodiscard]] Scene made_scene(const study::Study& study);

}  // namespace beatlas::build
