#include "pipeline/build/corrections.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/segment/known_labels.h"
#include "pipeline/segment/painting.h"
#include "runtime/base/error.h"

namespace beatlas::build {
namespace {

/// What the phases of given images are in a study of `count`.
/// @param otherwise what helps if they are not as many
std::vector<int> phases_of(const study::GivenLabels& given, int count,
                           const std::string& otherwise) {
  if (!given.phases.empty()) {
    if (given.phases.back() >= count) {
      throw_invalid("phase " + std::to_string(given.phases.back()) +
                    " is not known; the images have 0 to " + std::to_string(count - 1));
    }
    return given.phases;
  }
  if (given.images.phase_count() != count) {
    throw_invalid("it holds " + std::to_string(given.images.phase_count()) +
                  (given.images.phase_count() == 1 ? " image" : " images") + ", but the exam has " +
                  std::to_string(count) + " phases; save one for each, or " + otherwise);
  }
  std::vector<int> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

std::vector<segment::Seed> painted_seeds(const study::GivenLabels& painted, const Cine& stack) {
  std::vector<segment::Seed> seeds;
  const std::vector<int> phases =
      phases_of(painted, stack.phase_count(), "one alone, whose phase --seeds-phase tells");
  for (std::size_t image = 0; image < phases.size(); ++image) {
    const std::vector<segment::Seed> more = segment::seeds_of_painting(
        painted.images.grid, painted.images.phases[image], phases[image], stack.grid());
    seeds.insert(seeds.end(), more.begin(), more.end());
  }
  if (seeds.empty()) {
    throw_invalid("what it has painted lies outside the images; paint on an image of this exam");
  }
  return seeds;
}

segment::KnownLabels known_labels(const study::GivenLabels& given, const Cine& stack,
                                  const std::vector<Vec2>& drawn_shifted_mm) {
  segment::KnownLabels known{
      segment::labels_on_grid(given.images, stack.grid(), drawn_shifted_mm),
      phases_of(given, stack.phase_count(), "name the phases that they are with --labels-phases")};
  const auto heart_ml = [](const LabelCycle& labels) {
    double voxels = 0;
    for (const std::vector<std::uint8_t>& image : labels.phases) {
      voxels += static_cast<double>(image.size()) -
                static_cast<double>(std::count(image.begin(), image.end(), kLabelBackground)) -
                static_cast<double>(std::count(image.begin(), image.end(), kLabelUnknown));
    }
    return voxels * labels.grid.voxel_ml();
  };
  const double share = heart_ml(known.labels) / heart_ml(given.images);
  if (!(share >= 0.5)) {
    throw_invalid(std::string(share > 0 ? "most of its heart lies" : "its heart lies") +
                  " outside the images in the patient's space; it belongs to another exam, or was "
                  "moved or mirrored");
  }
  segment::check_known(known, stack.grid(), stack.phase_count());
  return known;
}

}  // namespace

Corrections corrections_for(const Exam& exam, const Orders& orders, StageContext& context) {
  const Cine& stack = exam.stack;
  Corrections out{orders.seeds, {}, {}};
  try {
    segment::check_seeds(out.seeds, stack.grid(), stack.phase_count());
    if (orders.painted) {
      const std::vector<segment::Seed> painted = painted_seeds(*orders.painted, stack);
      out.seeds.insert(out.seeds.end(), painted.begin(), painted.end());
    }
  } catch (const Error& error) {
    throw error.with_context(orders.seeds_from);
  }
  if (!orders.labels) return out;
  const bool move = orders.recipe.segment.labels_drawn_on == segment::LabelsDrawnOn::Imaged &&
                    !exam.slice_shifts_mm.empty();
  if (move) {
    context.warn(
        "the labels given were moved with the slices that lay shifted, as drawn on the images as "
        "they came; what was drawn on the study's own images is given with --labels-aligned, or, "
        "if all was, with /segment/labels_drawn_on aligned in a recipe");
  }
  try {
    out.known =
        known_labels(*orders.labels, stack, move ? exam.slice_shifts_mm : std::vector<Vec2>());
  } catch (const Error& error) {
    throw error.with_context(orders.labels_from);
  }
  if (orders.coverage.empty()) return out;
  try {
    if (move) {
      throw_invalid(
          "coverage cannot be moved with slices that import moved back; give what was drawn on the "
          "study's own images, and say so: /segment/labels_drawn_on aligned in a recipe");
    }
    for (const auto& [structure, given] : orders.coverage) {
      out.coverage[structure] = segment::on_voxels_of(given.images, structure, stack.grid());
    }
  } catch (const Error& error) {
    throw error.with_context(orders.coverage_from);
  }
  return out;
}

std::optional<LabelCycle> labels_as_acquired(const LabelCycle& labels, const Exam& exam) {
  if (exam.slice_shifts_mm.empty()) return {};
  std::vector<Vec2> back = exam.slice_shifts_mm;
  for (Vec2& shift : back) shift = -shift;
  return segment::labels_on_grid(labels, exam.stack.grid(), back);
}

void move_back(const Exam& exam, study::GivenLabels& given) {
  std::optional<LabelCycle> acquired = labels_as_acquired(given.images, exam);
  if (!acquired) return;
  given.images = std::move(*acquired);
  given.sha256 = study::given_sha256(given.images, given.phases);
}

study::GivenLabels with_other_phases(study::GivenLabels now, const study::GivenLabels& before) {
  if (now.phases.empty()) return now;
  std::map<int, std::vector<std::uint8_t>> images;
  for (std::size_t n = 0; n < before.images.phases.size(); ++n) {
    images[before.phases.empty() ? static_cast<int>(n) : before.phases[n]] =
        before.images.phases[n];
  }
  for (const int phase : now.phases) images.erase(phase);
  if (images.empty()) return now;
  const Grid& grid = now.images.grid;
  if (grid.size != before.images.grid.size ||
      !grid.mm_from_index.isApprox(before.images.grid.mm_from_index, 1e-6)) {
    throw_invalid("it lies on other voxels than the labels of phase " +
                  std::to_string(images.begin()->first) +
                  " that were given before; give all phases in one file, or those up with "
                  "--labels none");
  }
  for (std::size_t n = 0; n < now.phases.size(); ++n) {
    images[now.phases[n]] = std::move(now.images.phases[n]);
  }
  now.phases.clear();
  now.images.phases.clear();
  for (auto& [phase, image] : images) {
    now.phases.push_back(phase);
    now.images.phases.push_back(std::move(image));
  }
  // They are no file's any more: in whatever order they were given, they are the same.
  now.sha256 = study::given_sha256(now.images, now.phases);
  now.file_sha256 = now.sha256;
  return now;
}

Segmentation segment_with(const Exam& exam, const Corrections& corrections,
                          const segment::SegmentOptions& options, StageContext& context,
                          const prior::PriorCycle* prior) {
  if (corrections.known.phases.empty()) {
    return segment::segment_exam(exam, corrections.seeds, options, context, {}, prior);
  }
  const bool all =
      corrections.known.phases.size() == static_cast<std::size_t>(exam.stack.phase_count());
  if (all && !corrections.seeds.empty()) {
    context.warn("the seeds are not used: the labels given are of every phase");
  }
  return segment::segment_with_labels(exam, corrections.known, corrections.seeds, options, context,
                                      corrections.coverage, prior);
}

}  // namespace beatlas::build
