#include "pipeline/segment/base_cuts.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace beatlas::segment {
namespace {

/// LV blood of each phase in voxels.
std::vector<double> lv_voxels(const ImageCycle<std::uint8_t>& labels) {
  std::vector<double> volume;
  for (const std::vector<std::uint8_t>& phase : labels.phases) {
    volume.push_back(static_cast<double>(std::count(phase.begin(), phase.end(), kLabelLvBlood)));
  }
  return volume;
}

/// Flat ends half a gap beyond the most basal slice of each phase. A base that descends through a
/// stack of thick slices does so in leaps of whole slices; the base itself descends with the LV's
/// volume, so a straight line in it is laid through the leaps.
std::vector<double> flat_ends(const ImageCycle<std::uint8_t>& labels, Structure structure, int step,
                              const std::vector<double>& lv_volume) {
  const auto n = static_cast<std::size_t>(labels.phase_count());
  std::vector<double> ends(n);
  for (std::size_t p = 0; p < n; ++p) {
    const int k = most_basal(labels, p, structure, step);
    ends[p] = k < 0 ? (step > 0 ? labels.grid.size[2] : -1) : k + 0.5 * step;
  }
  const double count = static_cast<double>(n);
  const double mean_volume = std::accumulate(lv_volume.begin(), lv_volume.end(), 0.0) / count;
  const double mean_end = std::accumulate(ends.begin(), ends.end(), 0.0) / count;
  double square = 0;
  double product = 0;
  for (std::size_t p = 0; p < n; ++p) {
    square += (lv_volume[p] - mean_volume) * (lv_volume[p] - mean_volume);
    product += (lv_volume[p] - mean_volume) * (ends[p] - mean_end);
  }
  const double slope = square > 0 ? product / square : 0;
  for (std::size_t p = 0; p < n; ++p) {
    const double line = mean_end + slope * (lv_volume[p] - mean_volume);
    ends[p] = std::clamp(line, ends[p] - 0.75, ends[p] + 0.75);
  }
  return ends;
}

}  // namespace

int most_basal(const ImageCycle<std::uint8_t>& labels, std::size_t phase, Structure structure,
               int step) {
  const Grid& grid = labels.grid;
  for (int k = step > 0 ? grid.size[2] - 1 : 0; k >= 0 && k < grid.size[2]; k -= step) {
    const auto from =
        labels.phases[phase].begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
    if (std::any_of(from, from + static_cast<std::ptrdiff_t>(grid.slice_count()),
                    [&](std::uint8_t label) { return label_in_structure(label, structure); })) {
      return k;
    }
  }
  return -1;
}

std::map<Structure, BaseCut> flat_base_cuts(const ImageCycle<std::uint8_t>& labels, int base_step) {
  const std::vector<double> lv_volume = lv_voxels(labels);
  std::map<Structure, BaseCut> cuts;
  for (Structure structure : kVentricular) {
    cuts[structure] = {base_step, flat_ends(labels, structure, base_step, lv_volume)};
  }
  return cuts;
}

int base_step_from(const LabelCycle& labels) {
  std::array<double, 8> sum{};
  std::array<double, 8> number{};
  const std::size_t slice = labels.grid.slice_count();
  for (const std::vector<std::uint8_t>& phase : labels.phases) {
    for (std::size_t v = 0; v < phase.size(); ++v) {
      sum[phase[v]] += static_cast<double>(v / slice);
      number[phase[v]] += 1;
    }
  }
  const auto mean = [&](std::initializer_list<std::size_t> of) {
    double total = 0;
    double count = 0;
    for (const std::size_t l : of) {
      total += sum[l];
      count += number[l];
    }
    return count > 0 ? total / count : 0;
  };
  const double beyond = number[kLabelLaBlood] + number[kLabelRaBlood] + number[kLabelAorta];
  // A few stray voxels tell nothing.
  const double way = beyond > 0.05 * number[kLabelLvBlood]
                         ? mean({kLabelLaBlood, kLabelRaBlood, kLabelAorta}) - mean({kLabelLvBlood})
                         : mean({kLabelLvBlood}) - mean({kLabelLvMyocardium});
  return way < 0 ? -1 : 1;
}

}  // namespace beatlas::segment
