#include "pipeline/segment/valves.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>

#include "pipeline/segment/seeds.h"

namespace beatlas::segment {
namespace {

std::size_t count_label(const ImageCycle<std::uint8_t>& labels, std::size_t phase, int k,
                        std::uint8_t label) {
  const auto from =
      labels.phases[phase].begin() + static_cast<std::ptrdiff_t>(labels.grid.offset(0, 0, k));
  return static_cast<std::size_t>(
      std::count(from, from + static_cast<std::ptrdiff_t>(labels.grid.slice_count()), label));
}

/// Most basal slice with the structure in a phase; -1 if it has none.
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

/// Flat ends half a gap beyond the most basal slice of each phase. A base that descends through a
/// stack of thick slices does so in leaps; averaged over neighbouring phases it glides.
std::vector<double> flat_ends(const ImageCycle<std::uint8_t>& labels, Structure structure,
                              int step) {
  const auto n = static_cast<std::size_t>(labels.phase_count());
  std::vector<double> ends(n);
  for (std::size_t p = 0; p < n; ++p) {
    const int k = most_basal(labels, p, structure, step);
    ends[p] = k < 0 ? (step > 0 ? labels.grid.size[2] : -1) : k + 0.5 * step;
  }
  const std::vector<double> leaps = ends;
  for (int round = 0; n >= 5 && round < 2; ++round) {
    const std::vector<double> before = ends;
    for (std::size_t p = 0; p < n; ++p) {
      ends[p] =
          std::clamp(0.25 * before[(p + n - 1) % n] + 0.5 * before[p] + 0.25 * before[(p + 1) % n],
                     leaps[p] - 0.5, leaps[p] + 0.5);
    }
  }
  return ends;
}

}  // namespace

std::map<Structure, BaseCut> part_ventricles_from_atria(ImageCycle<std::uint8_t>& labels,
                                                        const Chambers& chambers,
                                                        double tricuspid_excursion_mm) {
  std::map<Structure, BaseCut> cuts;
  const Grid& grid = labels.grid;
  const double slice_mm = grid.spacing_mm()[2];
  if (!chambers.found_lv() || slice_mm < kThickSlicesMm) return cuts;
  const int step = chambers.base_step;
  const int base_k = step > 0 ? chambers.lv.back().k : chambers.lv.front().k;
  const int beyond = base_k + step;
  const auto n = static_cast<std::size_t>(labels.phase_count());
  const bool atria =
      beyond >= 0 && beyond < grid.size[2] &&
      cv::countNonZero(chambers.always_blood_moving[static_cast<std::size_t>(beyond)]) > 0;
  for (int k = beyond; atria && k >= 0 && k < grid.size[2]; k += step) {
    const std::size_t begin = grid.offset(0, 0, k);
    for (std::vector<std::uint8_t>& phase : labels.phases) {
      for (std::size_t v = begin; v < begin + grid.slice_count(); ++v) {
        if (phase[v] != kLabelBackground) phase[v] = kLabelRestOfHeart;
      }
    }
  }
  for (Structure structure : kAllStructures) {
    cuts[structure] = {step, flat_ends(labels, structure, step)};
  }
  if (!atria) return cuts;

  std::vector<double> lv_volume(n, 0);
  int lv_slices = 0;
  const auto ed = static_cast<std::size_t>(chambers.end_diastole);
  int rv_base_k = -1;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (std::size_t p = 0; p < n; ++p) {
      lv_volume[p] += static_cast<double>(count_label(labels, p, k, kLabelLvBlood));
    }
    lv_slices += count_label(labels, ed, k, kLabelLvMyocardium) > 0 ? 1 : 0;
    if (count_label(labels, ed, k, kLabelRvBlood) > 0 && (rv_base_k < 0 || step > 0)) rv_base_k = k;
  }
  const auto [least, most] = std::minmax_element(lv_volume.begin(), lv_volume.end());
  if (rv_base_k < 0 || *most <= *least) return cuts;

  const double excursion_mm =
      tricuspid_excursion_mm * std::min(1.3, lv_slices * slice_mm / kLvLengthMm);
  BaseCut cut;
  cut.base_step = step;
  for (std::size_t p = 0; p < n; ++p) {
    const double loss = (*most - lv_volume[p]) / (*most - *least);
    cut.k.push_back(rv_base_k + step * (0.5 - loss * excursion_mm / slice_mm));
    for (int k = 0; k < grid.size[2]; ++k) {
      if (step * (k - cut.k.back()) <= 0) continue;
      const std::size_t begin = grid.offset(0, 0, k);
      for (std::size_t v = begin; v < begin + grid.slice_count(); ++v) {
        std::uint8_t& label = labels.phases[p][v];
        if (label == kLabelRvBlood) label = kLabelRestOfHeart;
      }
    }
  }
  cuts[Structure::RvBlood] = cut;
  return cuts;
}

}  // namespace beatlas::segment
