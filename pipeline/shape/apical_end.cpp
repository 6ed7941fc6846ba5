#include "pipeline/shape/apical_end.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace beatlas::shape {
namespace {

constexpr double kGaps = 0.5;          ///< to an empty slice
constexpr double kLeastGaps = 0.1;     ///< beyond the stack: its last slice shows the structure
constexpr double kThinAtApex = 0.5;    ///< of the last slice's wall
constexpr double kAcrossSlices = 0.5;  ///< cosine: an axis that leans more runs along the slices

/// Most apical slice with a section; -1 if there is none.
int last_section(const Grid& grid, const std::vector<float>& coverage, int step) {
  const int nk = grid.size[2];
  for (int k = step > 0 ? nk - 1 : 0; k >= 0 && k < nk; k -= step) {
    if (section_voxels(grid, coverage, k) > 0) return k;
  }
  return -1;
}

/// From the centre of the last section, where that is the stack's last slice, to where sections
/// that shrink as the last two close; infinite where they do not shrink. None where the structure
/// ends within the stack, or has one slice.
/// @param last_in_stack toward the apex
std::optional<double> gaps_beyond(const Grid& grid, const std::vector<float>& coverage, int step,
                                  int last_in_stack) {
  const int last = last_section(grid, coverage, step);
  if (last != last_in_stack || last - step < 0 || last - step >= grid.size[2]) return {};
  const double here = section_voxels(grid, coverage, last);
  const double before = section_voxels(grid, coverage, last - step);
  return before > here ? here / (before - here) : std::numeric_limits<double>::infinity();
}

/// @param last_in_stack toward the apex
ApicalEnd end_of(const Grid& grid, const std::vector<float>& coverage, int step,
                 int last_in_stack) {
  ApicalEnd out{step, kGaps};
  if (const auto gaps = gaps_beyond(grid, coverage, step, last_in_stack)) {
    out.gaps = std::clamp(*gaps, kLeastGaps, kGaps);
  }
  return out;
}

/// Index in the coverage's grid.
int last_in_stack(const Segmentation& segmentation, int step) {
  return (step > 0 ? segmentation.labels.grid.size[2] - 1 : 0) - segmentation.coverage.first[2];
}

}  // namespace

double section_voxels(const Grid& grid, const std::vector<float>& coverage, int k) {
  const auto first = coverage.begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
  const auto last = first + static_cast<std::ptrdiff_t>(grid.slice_count());
  if (std::none_of(first, last, [](float c) { return c >= 0.5F; })) return 0;
  double sum = 0;
  std::for_each(first, last, [&](float c) { sum += static_cast<double>(c); });
  return sum;
}

bool holds_lv(const CoverageCycle& coverage) {
  return coverage.phases.count(Structure::LvBlood) != 0 &&
         coverage.phases.count(Structure::LvMyocardium) != 0;
}

std::vector<float> filled_lv(const CoverageCycle& coverage, std::size_t phase) {
  std::vector<float> out = coverage.phases.at(Structure::LvMyocardium)[phase];
  const std::vector<float>& blood = coverage.phases.at(Structure::LvBlood)[phase];
  std::transform(out.begin(), out.end(), blood.begin(), out.begin(),
                 [](float a, float b) { return std::min(1.0F, a + b); });
  return out;
}

int step_to_apex(const Segmentation& segmentation, const std::optional<LongAxis>& axis) {
  const auto plane = segmentation.valve_planes.find(Structure::LvMyocardium);
  if (plane != segmentation.valve_planes.end()) return -plane->second.base_step;
  if (!axis) return 0;
  const Grid& grid = segmentation.labels.grid;
  const Vec3 across = grid.mm_from_index.linear().col(2).normalized();
  const double along = across.dot(axis->towards_base);
  if (std::abs(along) < kAcrossSlices) return 0;
  return along > 0 ? -1 : 1;
}

ApicalEnds apical_ends(const Segmentation& segmentation, Structure structure, std::size_t phase,
                       int step) {
  ApicalEnds out{{step, kGaps}, {step, kGaps}};
  const CoverageCycle& coverage = segmentation.coverage;
  const auto own = coverage.phases.find(structure);
  if (step == 0 || own == coverage.phases.end()) return out;
  const Grid& grid = coverage.grid;
  const int stack = last_in_stack(segmentation, step);
  out.wall = out.cavity = end_of(grid, own->second[phase], step, stack);
  if (!holds_lv(coverage)) return out;
  const std::vector<float> filled = filled_lv(coverage, phase);
  const ApicalEnd lv = end_of(grid, filled, step, stack);
  const int last = last_section(grid, filled, step);
  if (structure != Structure::LvBlood && structure != Structure::LvMyocardium) {
    const bool same = last >= 0 && last_section(grid, own->second[phase], step) == last;
    if (structure == Structure::Heart && same) out.wall.gaps = std::max(out.wall.gaps, lv.gaps);
    return out;
  }
  const std::vector<float>& blood = coverage.phases.at(Structure::LvBlood)[phase];
  out.wall = lv;
  out.cavity = end_of(grid, blood, step, stack);
  if (last < 0 || section_voxels(grid, blood, last) == 0) return out;
  const Vec3 spacing = grid.spacing_mm();
  const auto radius_mm = [&](const std::vector<float>& part) {
    return std::sqrt(section_voxels(grid, part, last) * spacing[0] * spacing[1] / std::numbers::pi);
  };
  const double wall_gaps = kThinAtApex * (radius_mm(filled) - radius_mm(blood)) / spacing[2];
  // In a slice at the very tip cavity and wall share what is left.
  out.cavity.gaps = std::min(out.cavity.gaps, std::max(lv.gaps - wall_gaps, 0.5 * lv.gaps));
  return out;
}

double lv_gaps_beyond(const Segmentation& segmentation, std::size_t phase, int step) {
  const CoverageCycle& coverage = segmentation.coverage;
  const std::vector<float> filled = filled_lv(coverage, phase);
  return gaps_beyond(coverage.grid, filled, step, last_in_stack(segmentation, step)).value_or(0);
}

std::optional<double> lv_apex_k(const Segmentation& segmentation, std::size_t phase, int step) {
  const CoverageCycle& coverage = segmentation.coverage;
  if (step == 0 || !holds_lv(coverage)) return {};
  const std::vector<float> filled = filled_lv(coverage, phase);
  const int last = last_in_stack(segmentation, step);
  if (last_section(coverage.grid, filled, step) != last) return {};
  const ApicalEnd end = end_of(coverage.grid, filled, step, last);
  return coverage.first[2] + last + step * end.gaps;
}

}  // namespace beatlas::shape
