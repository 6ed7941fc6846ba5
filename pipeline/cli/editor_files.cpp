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
    const LabelCycle labels = one_of(study::read_segmentation(study).labels, phase);
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
