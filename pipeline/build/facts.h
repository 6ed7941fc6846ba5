#pragma once
/// What a package tells of its making beside its payloads.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/exam.h"
#include "pipeline/core/long_axis.h"
#include "pipeline/core/shapes.h"
#include "pipeline/report/curves.h"
#include "pipeline/study/stage.h"
#include "runtime/atlas/manifest.h"

namespace beatlas::build {

struct Facts {
  struct StageFact {
    std::string version;
    nlohmann::json options;
  };
  std::map<study::Stage, StageFact> stages;  ///< all but pictures and pack
  std::string input_sha256;                  ///< see stack_sha256
  std::string source_format;
  std::string phantom_identity;  ///< see Exam
  std::vector<std::string> decisions;
  std::vector<std::string> warnings;
  Grid source;  ///< of the stack
  double rr_interval_s = 0;
  std::vector<double> frame_times_s;  ///< of the source's frames, which may be more or fewer
  int phases = 0;                     ///< of the stack
  int end_diastole = 0;
  int end_systole = 0;
  std::vector<report::VolumeCurve> volumes;       ///< of the segmentation, in order of structure
  std::map<Structure, atlas::SurfaceBand> bands;  ///< of surfaces, see surface_bands.h
  std::optional<Affine> workspace_from_lps;
  std::optional<LongAxis> axis;  ///< the LV's; with a study that of its file counts
};

/// Takes what an exam tells of itself.
void take_exam(const Exam& exam, Facts& facts);
/// Takes what a segmentation tells of the heart: its phases, volumes and warnings, but no alarm.
void take_segmentation(const Segmentation& found, Facts& facts);

}  // namespace beatlas::build
