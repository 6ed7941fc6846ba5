#include "pipeline/cli/editor_files.h"

#include <array>
#include <cstdio>

#include "pipeline/build/orders.h"
#include "pipeline/cli/markups.h"
#include "pipeline/core/words.h"
#include "pipeline/formats/label_table.h"
#include "pipeline/study/files.h"
#include "pipeline/study/images.h"
#include "pipeline/study/stage_files.h"
#include "pipeline/study/state.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

std::string name_of(const char* stem, int phase, const char* end) {
  std::array<char, 48> name{};
  std::snprintf(name.data(), name.size(), "%s_%02d%s", stem, phase, end);
  return name.data();
}

template <class Cycle>
Cycle one_of(const Cycle& cycle, int phase) {
  return {cycle.grid, {cycle.phases[static_cast<std::size_t>(phase)]}};
}

/// Whether the segmentation was made from the exam as it lies there. Seeds and options that wait
/// for the next build make labels no labels of other images: an editor is where they are looked at.
bool is_segmented_from_exam(const study::Study& study) {
  return study.find(study::Stage::Segment)->inputs == study.inputs_now(study::Stage::Segment);
}

/// Labels that were edited by hand are kept by every command, whatever changed since, as long as
/// they lie on the images.
LabelCycle labels_of_exam(const study::Study& study, const Exam& exam) {
  const bool edited = !study::edited_outputs(study, study::Stage::Segment).empty();
  LabelCycle labels;
  if (edited || is_segmented_from_exam(study)) {
    labels = study::read_segmentation(study.folder()).labels;
    const Grid& grid = exam.stack.grid();
    if (labels.grid.size == grid.size &&
        labels.grid.mm_from_index.isApprox(grid.mm_from_index, 1e-9) &&
        labels.phase_count() == exam.stack.phase_count()) {
      return labels;
    }
  }
  throw_invalid("in the study " + study.folder().string() +
                " the stage segment is stale: the images were imported anew since; segment them "
                "first: beatlas segment --study " +
                shell_word(study.folder().string()) + (edited ? " --discard-edits" : ""));
}

}  // namespace

void export_for_editor(const fs::path& study, int phase, const fs::path& folder) {
  const study::Study opened = study::Study::open(study);
  if (opened.find(study::Stage::Import) == nullptr) {
    throw_invalid("the study " + study.string() + " holds no images yet; run: beatlas import " +
                  "SOURCE... --study " + shell_word(study.string()));
  }
  const Exam exam = study::read_exam(study);
  if (phase >= exam.stack.phase_count()) {
    throw_invalid("the study " + study.string() + " has the phases 0 to " +
                  std::to_string(exam.stack.phase_count() - 1));
  }
  const ImageCycle<float> image = one_of(exam.stack.images, phase);
  study::write_images(folder / name_of("image", phase, ".nii.gz"), image.phases, image.grid, 0);
  if (opened.find(study::Stage::Segment) != nullptr) {
    const LabelCycle labels = one_of(labels_of_exam(opened, exam), phase);
    study::write_labels(folder / name_of("labels", phase, ".nii.gz"), labels.phases, labels.grid,
                        0);
    study::write_text(folder / "labels.txt", formats::itk_snap_labels());
    study::write_text(folder / "labels.ctbl", formats::slicer_colour_table());
  }
  std::vector<segment::Seed> seeds = build::orders_of(opened).seeds;
  std::erase_if(seeds,
                [&](const segment::Seed& seed) { return seed.phase >= 0 && seed.phase != phase; });
  if (!seeds.empty()) {
    study::write_json(folder / name_of("seeds", phase, ".mrk.json"), seeds_to_markups(seeds));
  }
}

}  // namespace beatlas::cli
