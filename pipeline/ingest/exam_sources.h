#pragma once
/// The readers behind read_exam, one a format.

#include <filesystem>
#include <vector>

#include "pipeline/ingest/ingest.h"

namespace beatlas::ingest {

/// @param sources what the user named, for messages
/// @param files every file of the sources; `named` if the user named them one by one.
[[nodiscard]] Exam exam_from_dicom(const std::vector<std::filesystem::path>& sources,
                                   const std::vector<std::filesystem::path>& files, bool named,
                                   const IngestOptions& options, StageContext& context);

/// @param files image files other than DICOM, at least one: one 4-D file, or 3-D ones, a phase each
[[nodiscard]] Exam exam_from_images(const std::vector<std::filesystem::path>& files, bool as_given,
                                    const IngestOptions& options, StageContext& context);

/// @throws Error{InvalidInput} if a phase of the stack shows nothing (one value everywhere).
void check_signal(const ImageCycle<float>& images);

}  // namespace beatlas::ingest
