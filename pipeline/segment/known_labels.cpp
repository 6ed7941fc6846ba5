#include "pipeline/segment/known_labels.h"

#include <algorithm>
#include <functional>
#include <string>

#include "pipeline/core/segmented_volume.h"
#include "pipeline/core/slices.h"
#include "pipeline/core/words.h"
#include "pipeline/edges/coverage.h"
#include "pipeline/segment/edited_labels.h"
#include "pipeline/segment/known_ground.h"
#include "pipeline/segment/valve_planes.h"
#include "pipeline/segment/ventricle_ends.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

using Mask = std::vector<std::uint8_t>;

/// The largest label; what is unknown has none.
std::uint8_t most_of(const Mask& image) {
  std::uint8_t most = 0;
  for (const std::uint8_t label : image) {
    if (label != kLabelUnknown) most = std::max(most, label);
  }
  return most;
}

/// Of labels that are known in every phase.
Segmentation as_they_are(const LabelCycle& labels, const GivenCoverage& coverage,
                         StageContext& context) {
  const Grid& grid = labels.grid;
  Segmentation made;
  made.labels.grid = grid;
  made.labels.phases.assign(labels.phases.size(), Mask(grid.count(), kLabelBackground));
  const Box middle{{grid.size[0] / 2, grid.size[1] / 2, grid.size[2] / 2}, {1, 1, 1}};
  Box box = box_with_labels(grid, middle, {labels, {}});
  for (const auto& [structure, part] : coverage) {
    box = widened(grid, box, {part.first, part.share.grid.size});
  }
  made.coverage.first = box.first;
  made.coverage.grid = grid.part(box.first, box.size);
  const BaseSide base = base_side(labels);
  if (are_thick_slices(grid.spacing_mm()[2]) && base.step != 0) {
    made.valve_planes = estimated_valve_planes(labels, base.step);
  }
  made = with_other_labels(std::move(made), labels, context);
  if (coverage.empty()) return made;
  take_given_coverage(coverage, made);
  find_ends(made);
  for (const auto& [structure, phases] : made.coverage.phases) {
    if (coverage.count(structure) != 0) continue;
    context.warn("no coverage of " + std::string(structure_name(structure)) +
                 " was given; its labels tell where its surface runs");
  }
  return made;
}

}  // namespace

bool has_unknown(const KnownLabels& known) {
  return std::any_of(known.labels.phases.begin(), known.labels.phases.end(), [](const Mask& image) {
    return std::find(image.begin(), image.end(), kLabelUnknown) != image.end();
  });
}

void check_known(const KnownLabels& known, const Grid& grid, int phases) {
  const std::vector<int>& at = known.phases;
  if (at.empty() || at.size() != known.labels.phases.size() || at.front() < 0 ||
      at.back() >= phases ||
      std::adjacent_find(at.begin(), at.end(), std::greater_equal<>()) != at.end()) {
    throw_invalid("the labels hold " + std::to_string(known.labels.phases.size()) + " images for " +
                  std::to_string(at.size()) + " phases, which must be ascending and within 0 to " +
                  std::to_string(phases - 1));
  }
  if (!(known.labels.grid == grid)) throw_invalid("the labels are not on the grid of the images");
  for (std::size_t p = 0; p < at.size(); ++p) {
    const Mask& phase = known.labels.phases[p];
    const std::uint8_t most = most_of(phase);
    if (most == kLabelBackground) {
      throw_invalid("the labels hold no heart in phase " + std::to_string(at[p]));
    }
    if (most > kLastLabel) {
      throw_invalid("the labels hold the value " + std::to_string(most) + " in phase " +
                    std::to_string(at[p]) + "; use " + kLabelNumbers + ", 255 unknown");
    }
  }
}

Segmentation segment_with_labels(const Exam& exam, const KnownLabels& given,
                                 const std::vector<Seed>& seeds, const SegmentOptions& options,
                                 StageContext& context, const GivenCoverage& coverage,
                                 const prior::PriorCycle* prior) {
  const int phases = exam.stack.phase_count();
  check_known(given, exam.stack.grid(), phases);
  if (given.phases.size() == static_cast<std::size_t>(phases) && !has_unknown(given)) {
    return as_they_are(given.labels, coverage, context);
  }
  if (!coverage.empty()) {
    throw_invalid("coverage goes with labels of every phase, and " +
                  counted(given.phases.size(), "phase") + " of " + std::to_string(phases) +
                  " are labelled; leave the coverage out");
  }
  // Atria of some phases alone cannot be told from the rest of the heart in the others.
  KnownLabels known = given;
  for (Mask& phase : known.labels.phases) {
    std::transform(phase.begin(), phase.end(), phase.begin(), ventricles_apart);
  }
  SegmentOptions without_atria = options;
  without_atria.atria = false;
  Segmentation made = segment_exam(exam, seeds, without_atria, context, known, prior);
  LabelCycle labels = made.labels;
  put_known(known, labels);
  made = with_other_labels(std::move(made), labels, context);
  for (auto& [structure, plane] : made.valve_planes) {
    for (const int phase : known.phases) {
      const auto p = static_cast<std::size_t>(phase);
      const int k = most_basal(labels, p, structure, plane.base_step);
      if (k >= 0) plane.k[p] = k + 0.5 * plane.base_step;
    }
  }
  std::vector<char> changed(static_cast<std::size_t>(phases));
  for (const int phase : known.phases) changed[static_cast<std::size_t>(phase)] = 1;
  follow_changed_labels(made, changed);
  return made;
}

}  // namespace beatlas::segment
