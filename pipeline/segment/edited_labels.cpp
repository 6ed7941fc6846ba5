#include "pipeline/segment/edited_labels.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pipeline/core/box.h"
#include "pipeline/core/parallel.h"
#include "pipeline/core/segmented_volume.h"
#include "pipeline/core/slices.h"
#include "pipeline/core/structure_mask.h"
#include "pipeline/core/words.h"
#include "pipeline/edges/boundary.h"
#include "pipeline/edges/coverage.h"
#include "pipeline/edges/mask_surface.h"
#include "pipeline/segment/belief.h"
#include "pipeline/segment/valve_planes.h"
#include "pipeline/segment/ventricle_ends.h"
#include "pipeline/tissue/tissue.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

constexpr int kOutlinePx = 2;  // an outline is smoothed over one pixel and its neighbours
constexpr int kReachThin = 1;  // where a surface runs along thin slices, labels reach into the next

void check_labels(const Segmentation& made, const LabelCycle& labels) {
  if (labels.grid.size != made.labels.grid.size ||
      labels.phase_count() != made.labels.phase_count()) {
    throw_invalid("the labels have another size or number of phases than those made");
  }
  for (std::size_t p = 0; p < labels.phases.size(); ++p) {
    for (const std::uint8_t label : labels.phases[p]) {
      if (label > kLastLabel) {
        throw_invalid("the labels hold the value " + std::to_string(label) + " in phase " +
                      std::to_string(p) + "; use " + kLabelNumbers);
      }
    }
  }
}

/// The smallest box that holds the part with coverage and, with a margin, every heart label.
Box box_of(const CoverageCycle& coverage, const LabelCycle& labels) {
  const Grid& grid = labels.grid;
  return widened(grid, {coverage.first, coverage.grid.size}, box_around(grid, labels.phases));
}

/// The same coverage on a larger part of the grid.
void enlarge(CoverageCycle& coverage, BoundaryUncertainty& uncertainty, const Grid& whole,
             const Box& box) {
  if (box.first == coverage.first && box.size == coverage.grid.size) return;
  const Grid old = coverage.grid;
  const Grid grid = whole.part(box.first, box.size);
  Index3 shift{};
  for (std::size_t a = 0; a < 3; ++a) shift[a] = coverage.first[a] - box.first[a];
  for (auto& [structure, phases] : coverage.phases) {
    for (std::vector<float>& phase : phases) {
      std::vector<float> next(grid.count(), 0.0F);
      for (int k = 0; k < old.size[2]; ++k) {
        for (int j = 0; j < old.size[1]; ++j) {
          const auto from = phase.begin() + static_cast<std::ptrdiff_t>(old.offset(0, j, k));
          std::copy(from, from + old.size[0],
                    next.begin() + static_cast<std::ptrdiff_t>(
                                       grid.offset(shift[0], j + shift[1], k + shift[2])));
        }
      }
      phase = std::move(next);
    }
  }
  for (auto& [structure, phases] : uncertainty) {
    for (std::vector<BoundaryPoint>& points : phases) {
      for (BoundaryPoint& point : points) {
        const std::size_t in_slice = point.voxel % old.slice_count();
        const auto i = static_cast<int>(in_slice % static_cast<std::size_t>(old.size[0]));
        const auto j = static_cast<int>(in_slice / static_cast<std::size_t>(old.size[0]));
        const auto k = static_cast<int>(point.voxel / old.slice_count());
        point.voxel =
            static_cast<std::uint32_t>(grid.offset(i + shift[0], j + shift[1], k + shift[2]));
      }
    }
  }
  coverage.grid = grid;
  coverage.first = box.first;
}

/// Sets what lies about a voxel, as far as its label is felt in plane and so many slices away.
void set_around(const Grid& grid, int i, int j, int k, int slices,
                std::vector<std::uint8_t>& zone) {
  for (int c = std::max(0, k - slices); c <= std::min(grid.size[2] - 1, k + slices); ++c) {
    for (int b = std::max(0, j - kOutlinePx); b <= std::min(grid.size[1] - 1, j + kOutlinePx);
         ++b) {
      for (int a = std::max(0, i - kOutlinePx); a <= std::min(grid.size[0] - 1, i + kOutlinePx);
           ++a) {
        zone[grid.offset(a, b, c)] = 1;
      }
    }
  }
}

/// 1 where labels changed and around, as far as that is felt; empty if nothing did.
std::vector<std::uint8_t> changed_zone(const Grid& grid, const std::vector<std::uint8_t>& before,
                                       const std::vector<std::uint8_t>& after) {
  const int slices = are_thick_slices(grid.spacing_mm()[2]) ? 0 : kReachThin;
  std::vector<std::uint8_t> zone;
  for_each_voxel(grid, [&](int i, int j, int k, std::size_t v) {
    if (before[v] == after[v]) return;
    if (zone.empty()) zone.resize(grid.count(), 0);
    set_around(grid, i, j, k, slices, zone);
  });
  return zone;
}

/// Moves the plane of one phase half a slice beyond the farthest label of its structure where
/// labels were painted beyond it, or taken away up to it.
void follow_paint(const ImageCycle<std::uint8_t>& before, const ImageCycle<std::uint8_t>& after,
                  std::size_t phase, Structure structure, int first_k, ValvePlane& plane) {
  const int last = most_basal(after, phase, structure, plane.base_step);
  if (last < 0) return;
  const int had = most_basal(before, phase, structure, plane.base_step);
  const bool beyond = plane.base_step * (last + first_k - plane.k[phase]) > 0;
  const bool receded = had >= 0 && plane.base_step * (had - last) > 0;
  if (beyond || receded) plane.k[phase] = last + first_k + 0.5 * plane.base_step;
}

/// Coverage by the outlines of what is labelled in one phase.
class LabelOutlines {
 public:
  /// All must outlive this.
  LabelOutlines(const Grid& grid, const std::vector<std::uint8_t>& before,
                const std::vector<std::uint8_t>& after)
      : grid_(grid),
        labels_(after),
        whole_(!are_thick_slices(grid.spacing_mm()[2]) &&
               std::all_of(before.begin(), before.end(),
                           [](std::uint8_t label) { return label == kLabelBackground; })),
        blood_(coverage_of(where(after, Structure::LvBlood))) {}

  [[nodiscard]] std::vector<float> of(Structure structure) const {
    if (structure == Structure::LvBlood) return blood_;
    if (structure == Structure::LvMyocardium) return of_wall();
    return coverage_of(where(labels_, structure));
  }

 private:
  /// What the whole ventricle holds beside blood: a thin wall keeps its volume so.
  [[nodiscard]] std::vector<float> of_wall() const {
    std::vector<std::uint8_t> ventricle = where(labels_, Structure::LvMyocardium);
    const std::vector<std::uint8_t> cavity = where(labels_, Structure::LvBlood);
    for (std::size_t v = 0; v < ventricle.size(); ++v) ventricle[v] |= cavity[v];
    std::vector<float> outline = coverage_of(ventricle);
    for (std::size_t v = 0; v < outline.size(); ++v) {
      outline[v] = std::max(0.0F, outline[v] - blood_[v]);
    }
    return outline;
  }

  [[nodiscard]] std::vector<float> coverage_of(const std::vector<std::uint8_t>& mask) const {
    return whole_ ? edges::smooth_coverage(grid_, mask) : edges::outline_coverage(grid_, mask);
  }

  const Grid& grid_;
  const std::vector<std::uint8_t>& labels_;
  /// A body given as a whole is as smooth across slices as in them; a stroke is of its own slice.
  bool whole_;
  std::vector<float> blood_;
};

void drop_or_refuse_absent(CoverageCycle& coverage) {
  std::erase_if(coverage.phases, [](const auto& entry) {
    std::size_t empty = 0;
    std::size_t first_empty = 0;
    for (std::size_t p = entry.second.size(); p-- > 0;) {
      if (std::none_of(entry.second[p].begin(), entry.second[p].end(),
                       [](float c) { return c >= 0.5F; })) {
        ++empty;
        first_empty = p;
      }
    }
    if (empty > 0 && empty < entry.second.size()) {
      throw_invalid("the labels hold " + std::string(structure_name(entry.first)) +
                    " in some phases but not in phase " + std::to_string(first_empty) +
                    "; paint it in every phase or in none");
    }
    return empty > 0;
  });
  if (coverage.phases.count(Structure::Heart) == 0) {
    throw_invalid("the labels hold no heart");
  }
}

}  // namespace

Segmentation with_other_labels(Segmentation made, const LabelCycle& labels, StageContext& context) {
  check_labels(made, labels);
  CoverageCycle& coverage = made.coverage;
  const Box box = box_of(coverage, labels);
  enlarge(coverage, made.uncertainty, labels.grid, box);
  const ImageCycle<std::uint8_t> before = crop(made.labels, box);
  const ImageCycle<std::uint8_t> after = crop(labels, box);
  const Grid& grid = coverage.grid;
  const auto n = static_cast<std::size_t>(labels.phase_count());
  for (Structure structure : kAllStructures) {
    auto& phases = coverage.phases[structure];
    if (phases.empty()) phases.assign(n, std::vector<float>(grid.count(), 0.0F));
  }

  parallel_for(n, [&](std::size_t p) {
    context.check_cancelled();
    const std::vector<std::uint8_t> zone = changed_zone(grid, before.phases[p], after.phases[p]);
    for (auto& [structure, plane] : made.valve_planes) {
      follow_paint(before, after, p, structure, box.first[2], plane);
    }
    if (zone.empty()) return;
    const LabelOutlines outlines(grid, before.phases[p], after.phases[p]);
    for (auto& [structure, phases] : coverage.phases) {
      const std::vector<float> outline = outlines.of(structure);
      for (std::size_t v = 0; v < zone.size(); ++v) {
        if (zone[v] != 0) phases[p][v] = outline[v];
      }
    }
    for (auto& [structure, phases] : made.uncertainty) {
      std::erase_if(phases[p], [&](const BoundaryPoint& point) { return zone[point.voxel] != 0; });
    }
  });

  believe_painted(made.labels, labels, made.belief);
  made.labels = labels;
  drop_or_refuse_absent(coverage);
  std::erase_if(made.uncertainty,
                [&](const auto& entry) { return coverage.phases.count(entry.first) == 0; });
  std::erase_if(made.valve_planes,
                [&](const auto& plane) { return coverage.phases.count(plane.first) == 0; });
  find_ends(made);
  std::vector<char> changed(n);
  for (std::size_t p = 0; p < n; ++p) changed[p] = before.phases[p] != after.phases[p] ? 1 : 0;
  follow_changed_labels(made, changed);
  made.alarms.clear();
  return made;
}

Segmentation with_edited_labels(Segmentation made, const LabelCycle& labels,
                                StageContext& context) {
  const LabelCycle before = made.labels;
  made = with_other_labels(std::move(made), labels, context);
  std::size_t changed = 0;
  std::size_t phases_changed = 0;
  for (std::size_t p = 0; p < labels.phases.size(); ++p) {
    std::size_t here = 0;
    for (std::size_t v = 0; v < labels.phases[p].size(); ++v) {
      here += labels.phases[p][v] != before.phases[p][v] ? 1 : 0;
    }
    changed += here;
    phases_changed += here > 0 ? 1 : 0;
  }
  if (changed > 0) {
    made.warnings.push_back("the labels were edited by hand (" + counted(changed, "voxel") +
                            " in " + counted(phases_changed, "phase") + ")");
  }
  return made;
}

}  // namespace beatlas::segment
