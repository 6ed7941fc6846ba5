#include "pipeline/segment/threshold_growing.h"

#include <algorithm>
#include <string>

#include "pipeline/core/parallel.h"
#include "pipeline/core/segmented_volume.h"
#include "pipeline/core/structure_mask.h"
#include "pipeline/edges/boundary.h"
#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/segment/known_ground.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

IntensityWindow window_of(const SegmentOptions& options, const tissue::TissueLevels& levels) {
  IntensityWindow window{options.threshold_low, options.threshold_high,
                         options.threshold_neighbours};
  if (!(window.low > 0)) window.low = levels.threshold;
  if (!(window.high > 0)) window.high = 2 * levels.blood - levels.threshold;
  if (!(window.high > window.low)) {
    throw_invalid("the window of intensity runs from " + std::to_string(window.low) + " to " +
                  std::to_string(window.high) +
                  "; set threshold_low below threshold_high in the recipe's section segment");
  }
  return window;
}

/// Places of LV blood's seeds in the whole grid, of each phase.
std::vector<std::vector<std::size_t>> seed_voxels(const Grid& grid, std::size_t phases,
                                                  const std::vector<Seed>& drawn,
                                                  const LabelImages& automatic, const Box& box) {
  std::vector<std::vector<std::size_t>> out(phases);
  std::vector<Seed> blood;
  for (const Seed& seed : drawn) {
    if (seed.label != kLabelLvBlood) continue;
    blood.push_back(seed);
    blood.back().phase = -1;
  }
  if (!blood.empty()) {
    LabelImages marks(1, std::vector<std::uint8_t>(grid.count(), kUnlabelled));
    draw_seeds(grid, blood, marks);
    for (std::size_t v = 0; v < grid.count(); ++v) {
      if (marks[0][v] == kLabelLvBlood) out[0].push_back(v);
    }
    std::fill(out.begin() + 1, out.end(), out[0]);
    return out;
  }
  const Grid part = grid.part(box.first, box.size);
  for (std::size_t p = 0; p < phases; ++p) {
    for (int k = 0; k < box.size[2]; ++k) {
      for (int j = 0; j < box.size[1]; ++j) {
        for (int i = 0; i < box.size[0]; ++i) {
          if (automatic[p][part.offset(i, j, k)] != kLabelLvBlood) continue;
          out[p].push_back(grid.offset(box.first[0] + i, box.first[1] + j, box.first[2] + k));
        }
      }
    }
  }
  return out;
}

/// Calls visit(voxel) for those around one, all offsets in the grid.
template <class Visit>
void for_neighbours(const Grid& grid, std::size_t voxel, Neighbours neighbours,
                    const Visit& visit) {
  const Index3 at = index_of(grid, voxel);
  for (int c = -1; c <= 1; ++c) {
    for (int b = -1; b <= 1; ++b) {
      for (int a = -1; a <= 1; ++a) {
        const int apart = std::abs(a) + std::abs(b) + std::abs(c);
        if (apart == 0 || (apart > 1 && neighbours == Neighbours::Faces)) continue;
        if (!grid.contains(at[0] + a, at[1] + b, at[2] + c)) continue;
        visit(grid.offset(at[0] + a, at[1] + b, at[2] + c));
      }
    }
  }
}

}  // namespace

std::vector<std::uint8_t> grow_in_window(const Grid& grid, const std::vector<float>& image,
                                         const std::vector<std::size_t>& seeds,
                                         const IntensityWindow& window) {
  std::vector<std::uint8_t> grown(image.size(), 0);
  std::vector<std::size_t> front;
  const auto visit = [&](std::size_t v) {
    const auto value = static_cast<double>(image[v]);
    if (grown[v] != 0 || value < window.low || value > window.high) return;
    grown[v] = 1;
    front.push_back(v);
  };
  for (const std::size_t seed : seeds) visit(seed);
  while (!front.empty()) {
    const std::size_t v = front.back();
    front.pop_back();
    for_neighbours(grid, v, window.neighbours, visit);
  }
  return grown;
}

Segmentation segment_by_threshold(const ImageCycle<float>& stack, const std::vector<Seed>& drawn,
                                  const LabelImages& automatic, const Box& box,
                                  const tissue::TissueLevels& levels,
                                  const SegmentOptions& options) {
  const std::size_t n = stack.phases.size();
  const IntensityWindow window = window_of(options, levels);
  const auto seeds = seed_voxels(stack.grid, n, drawn, automatic, box);

  Segmentation out;
  out.labels.grid = stack.grid;
  out.labels.phases.resize(n);
  parallel_for(n, [&](std::size_t p) {
    std::vector<std::uint8_t>& labels = out.labels.phases[p];
    labels = grow_in_window(stack.grid, stack.phases[p], seeds[p], window);
    for (std::uint8_t& label : labels) label = label != 0 ? kLabelLvBlood : kLabelBackground;
  });
  for (std::size_t p = 0; p < n; ++p) {
    const std::vector<std::uint8_t>& labels = out.labels.phases[p];
    if (std::find(labels.begin(), labels.end(), kLabelLvBlood) != labels.end()) continue;
    throw_invalid("threshold growing found nothing in phase " + std::to_string(p) +
                  ": no seed of LV blood lies on an intensity of " + std::to_string(window.low) +
                  " to " + std::to_string(window.high) +
                  "; give seeds with --seeds, or threshold_low and threshold_high in the recipe");
  }
  const Box around = box_with_labels(stack.grid, box, {out.labels, {}});
  out.coverage.first = around.first;
  out.coverage.grid = stack.grid.part(around.first, around.size);
  const ImageCycle<std::uint8_t> part = crop(out.labels, around);
  std::vector<std::vector<float>> covered(n);
  parallel_for(n, [&](std::size_t p) {
    covered[p] = edges::outline_coverage(part.grid, where(part.phases[p], Structure::LvBlood));
  });
  out.coverage.phases[Structure::LvBlood] = covered;
  out.coverage.phases[Structure::Heart] = std::move(covered);
  find_ends(out);
  out.warnings.emplace_back(
      "LV blood was grown by a threshold alone, which stops at no wall that is as bright; look at "
      "the pictures, or use the method competition");
  return out;
}

}  // namespace beatlas::segment
