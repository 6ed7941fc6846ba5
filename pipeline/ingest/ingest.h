#pragma once
#include <filesystem>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::ingest {

struct IngestOptions {
  double rr_interval_s = 0;  ///< [s] overrides the R-R interval of the source if > 0
  int phases = 0;  ///< common phases to resample to; 0 = as many as the stack's slices have
};

/// Reads a DICOM folder (a whole mixed exam, each slice its own series, any order), or one 4-D
/// NIfTI file, into an Exam. The stack is the one with most parallel slices, then most phases.
/// @throws Error{InvalidInput} with the file or folder and the reason.
[[nodiscard]] Exam read_exam(const std::vector<std::filesystem::path>& sources,
                             const IngestOptions& options, StageContext& context);

}  // namespace beatlas::ingest
