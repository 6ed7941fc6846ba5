#include "pipeline/build/facts.h"

#include "pipeline/build/surface_bands.h"
#include "pipeline/core/segmented_volume.h"

namespace beatlas::build {

void take_exam(const Exam& exam, Facts& facts) {
  facts.source_format = exam.source_format;
  facts.phantom_identity = exam.phantom_identity;
  facts.decisions = exam.decisions;
  facts.source = exam.stack.grid();
  facts.rr_interval_s = exam.stack.rr_interval_s;
  facts.frame_times_s = exam.stack.frame_times_s;
  facts.phases = exam.stack.phase_count();
}

void take_segmentation(const Segmentation& found, Facts& facts) {
  facts.end_diastole = found.end_diastole;
  facts.end_systole = found.end_systole;
  facts.warnings = found.warnings;
  facts.axis = found.axis;
  facts.bands = surface_bands(found);
  facts.volumes.clear();
  for (const Structure structure : kAllStructures) {
    if (found.coverage.phases.count(structure) == 0) {
      if (is_beyond_base(structure)) continue;
      facts.warnings.push_back(std::string(structure_name(structure)) + " was not found");
      continue;
    }
    facts.volumes.push_back({structure, segmented_volume_ml(found, structure)});
  }
}

}  // namespace beatlas::build
