#pragma once
/// What a model says of an exam, as the command line asks it.

#include <filesystem>
#include <optional>

#include "pipeline/motion/bad_frames.h"
#include "pipeline/prior/prior.h"

namespace beatlas::test {

[[nodiscard]] inline prior::PriorCycle learned(
    const Exam& exam, const std::filesystem::path& file = prior::default_model_path()) {
  const prior::Model model = prior::Model::load(file);
  const std::optional<Exam> mended = motion::without_bad_frames(exam);
  StageContext context;
  return prior::heart_prior(mended ? *mended : exam, model, context);
}

}  // namespace beatlas::test
