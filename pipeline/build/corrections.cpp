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

bool holds_heart(const std::vector<std::uint8_t>& labels) {
  return std::any_of(labels.begin(), labels.end(), [](std::uint8_t label) {
    return label != kLabelBackground && label != kLabelUnknown;
  });
}

using PhaseImages = std::map<int, std::vector<std::uint8_t>>;

/// Labels of phases, every slice that many phases earlier: a phase may then be known in some of its
/// slices.
/// @param lags [slice of the labels' grid]; empty: none
/// @param otherwise what other slices of a phase hold; phases that are not there: unknown
segment::KnownLabels earlier(segment::KnownLabels drawn, const std::vector<int>& lags, int phases,
                             const PhaseImages& otherwise = {}) {
  if (lags.empty()) return drawn;
  const std::size_t count = drawn.labels.grid.slice_count();
  PhaseImages images;
  for (std::size_t n = 0; n < drawn.phases.size(); ++n) {
    for (std::size_t k = 0; k < lags.size(); ++k) {
      const int phase = ((drawn.phases[n] - lags[k]) % phases + phases) % phases;
      if (images.count(phase) == 0) {
        const auto before = otherwise.find(phase);
        images[phase] = before != otherwise.end()
                            ? before->second
                            : std::vector<std::uint8_t>(drawn.labels.grid.count(), kLabelUnknown);
      }
      std::copy_n(drawn.labels.phases[n].begin() + static_cast<std::ptrdiff_t>(k * count), count,
                  images[phase].begin() + static_cast<std::ptrdiff_t>(k * count));
    }
  }
  segment::KnownLabels out{{drawn.labels.grid, {}}, {}};
  for (auto& [phase, image] : images) {
    out.phases.push_back(phase);
    out.labels.phases.push_back(std::move(image));
  }
  return out;
}

/// The phases of which a heart is known.
segment::KnownLabels with_heart(segment::KnownLabels known) {
  segment::KnownLabels out{{known.labels.grid, {}}, {}};
  for (std::size_t n = 0; n < known.phases.size(); ++n) {
    if (!holds_heart(known.labels.phases[n])) continue;
    out.phases.push_back(known.phases[n]);
    out.labels.phases.push_back(std::move(known.labels.phases[n]));
  }
  return out;
}

/// [phase] images of given labels, where they lie on the grid.
PhaseImages images_of(const study::GivenLabels& given, const Grid& grid) {
  PhaseImages out;
  if (given.images.grid.size != grid.size ||
      !given.images.grid.mm_from_index.isApprox(grid.mm_from_index, 1e-6)) {
    return out;
  }
  for (std::size_t n = 0; n < given.images.phases.size(); ++n) {
    out[given.phases.empty() ? static_cast<int>(n) : given.phases[n]] = given.images.phases[n];
  }
  return out;
}

std::vector<int> negated(std::vector<int> lags) {
  for (int& lag : lags) lag = -lag;
  return lags;
}

segment::KnownLabels known_labels(const study::GivenLabels& given, const Cine& stack,
                                  const std::vector<Vec2>& drawn_shifted_mm,
                                  const std::vector<int>& drawn_late) {
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
  if (!drawn_late.empty()) {
    known = with_heart(earlier(std::move(known), drawn_late, stack.phase_count()));
  }
  segment::check_known(known, stack.grid(), stack.phase_count());
  return known;
}

bool are_moved(const Exam& exam) {
  return !exam.slice_shifts_mm.empty() || !exam.slice_lags.empty();
}

/// Labels of the exam's own images, on the images as they came.
/// @param otherwise what slices of a phase hold that the labels say nothing of
segment::KnownLabels as_acquired(segment::KnownLabels labels, const Exam& exam,
                                 const PhaseImages& otherwise = {}) {
  std::vector<Vec2> back = exam.slice_shifts_mm;
  for (Vec2& shift : back) shift = -shift;
  labels.labels = segment::labels_on_grid(labels.labels, exam.stack.grid(), back);
  return earlier(std::move(labels), negated(exam.slice_lags), exam.stack.phase_count(), otherwise);
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
  const bool move =
      orders.recipe.segment.labels_drawn_on == segment::LabelsDrawnOn::Imaged && are_moved(exam);
  if (move) {
    context.warn(
        "the labels given were moved with the slices that lay shifted or out of step, as drawn on "
        "the images as they came; what was drawn on the study's own images is given with "
        "--labels-aligned, or, if all was, with /segment/labels_drawn_on aligned in a recipe");
  }
  try {
    out.known =
        known_labels(*orders.labels, stack, move ? exam.slice_shifts_mm : std::vector<Vec2>(),
                     move ? exam.slice_lags : std::vector<int>());
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
  if (!are_moved(exam)) return {};
  std::vector<int> phases(labels.phases.size());
  std::iota(phases.begin(), phases.end(), 0);
  return as_acquired({labels, std::move(phases)}, exam).labels;
}

void move_back(const Exam& exam, const std::optional<study::GivenLabels>& before,
               study::GivenLabels& given) {
  if (!are_moved(exam)) return;
  const bool all = given.phases.empty();
  std::vector<int> phases = given.phases;
  if (all) {
    phases.resize(given.images.phases.size());
    std::iota(phases.begin(), phases.end(), 0);
  }
  const int count = exam.stack.phase_count();
  const bool fits = all ? static_cast<int>(phases.size()) == count : phases.back() < count;
  if (!fits) return;  // corrections_for refuses it in the user's own words
  segment::KnownLabels acquired =
      as_acquired({std::move(given.images), std::move(phases)}, exam,
                  before ? images_of(*before, exam.stack.grid()) : PhaseImages());
  given.images = std::move(acquired.labels);
  if (!all) given.phases = std::move(acquired.phases);
  given.sha256 = study::given_sha256(given.images, given.phases);
}

study::GivenLabels with_other_phases(study::GivenLabels now, const study::GivenLabels& before) {
  if (now.phases.empty()) return now;
  PhaseImages images = images_of(before, before.images.grid);
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
  if (all && !corrections.seeds.empty() && !segment::has_unknown(corrections.known)) {
    context.warn("the seeds are not used: the labels given are of every phase");
  }
  return segment::segment_with_labels(exam, corrections.known, corrections.seeds, options, context,
                                      corrections.coverage, prior);
}

}  // namespace beatlas::build
