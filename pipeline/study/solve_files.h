#pragma once
/// solve/: what a segmentation leaves so that the next one, with other seeds, need not begin anew.
/// It saves time and nothing else: what is missing, changed or of other images is left aside.

#include "pipeline/core/solve_memory.h"
#include "pipeline/study/stage_files.h"
#include "pipeline/study/study.h"

namespace beatlas::study {

/// @param key tells images and options that the memory holds for
FileList write_solve_memory(const std::filesystem::path& study, const SolveMemory& memory,
                            const std::string& key, double frame_interval_s);

/// Empty if there is none with this key whose files are as the stage `segment` left them.
[[nodiscard]] SolveMemory read_solve_memory(const Study& study, const std::string& key);

}  // namespace beatlas::study
