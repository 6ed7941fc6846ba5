#include "pipeline/segment/drawn_ends.h"

#include <algorithm>
#include <numeric>
#include <optional>

namespace beatlas::segment {
namespace {

/// Of the areas of two thirds of the ventricle; less tells nothing.
constexpr double kClearlyWider = 1.2;

/// Farthest slice of a phase along `step` with one of the labels; -1 if there is none.
int farthest_slice(const Grid& grid, const std::vector<std::uint8_t>& marks,
                   const std::vector<std::uint8_t>& of, int step) {
  for (int k = step > 0 ? grid.size[2] - 1 : 0; k >= 0 && k < grid.size[2]; k -= step) {
    const auto from = marks.begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
    const auto to = from + static_cast<std::ptrdiff_t>(grid.slice_count());
    if (std::find_first_of(from, to, of.begin(), of.end()) != to) return k;
  }
  return -1;
}

void reach(const std::vector<int>& drawn_k, int step, std::optional<std::vector<double>>& planes) {
  if (!planes) return;
  for (std::size_t p = 0; p < planes->size(); ++p) {
    (*planes)[p] = reaching((*planes)[p], drawn_k[p], step);
  }
}

}  // namespace

std::vector<int> doubted_base(const Chambers& chambers) {
  const std::size_t count = chambers.lv.size();
  if (count < 2) return {};
  const auto ed = static_cast<std::size_t>(chambers.end_diastole);
  const std::size_t third = std::max<std::size_t>(1, count / 3);
  const auto area = [&](std::size_t first) {
    double sum = 0;
    for (std::size_t at = first; at < first + third; ++at) {
      sum += chambers.lv[at].rings[ed].area_mm2;
    }
    return sum;
  };
  const bool up = chambers.base_step > 0;
  const std::size_t base = up ? count - third : 0;
  if (area(up ? 0 : count - third) <= kClearlyWider * area(base)) return {};
  std::vector<int> out;
  for (std::size_t at = base; at < base + third; ++at) out.push_back(chambers.lv[at].k);
  return out;
}

DrawnReach drawn_reach(const Grid& grid, const LabelImages& marks, int base_step) {
  DrawnReach out;
  for (const std::vector<std::uint8_t>& phase : marks) {
    out.lv_base.push_back(
        farthest_slice(grid, phase, {kLabelLvBlood, kLabelLvMyocardium}, base_step));
    out.lv_apex.push_back(farthest_slice(grid, phase, {kLabelLvBlood}, -base_step));
    out.rv_base.push_back(farthest_slice(grid, phase, {kLabelRvBlood}, base_step));
  }
  return out;
}

void reach_drawn_slices(const DrawnReach& drawn, int base_step, VentricleEnds& ends) {
  ends.drawn = drawn;
  reach(drawn.lv_base, base_step, ends.lv);
  reach(drawn.rv_base, base_step, ends.rv);
  reach(drawn.lv_apex, -base_step, ends.lv_apex);
}

}  // namespace beatlas::segment
