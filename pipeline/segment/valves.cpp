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

/// Where the LV's label ends towards the base, half a gap beyond its last slice, from `least_k` on:
/// whole slices, so a straight line in the LV's volume loss is laid through the phases.
std::vector<double> plane_of_labels(const ImageCycle<std::uint8_t>& labels, int least_k, int step) {
  const auto n = static_cast<std::size_t>(labels.phase_count());
  std::vector<double> volume(n, 0);
  std::vector<double> end_k(n, least_k);
  for (std::size_t p = 0; p < n; ++p) {
    for (int k = 0; k < labels.grid.size[2]; ++k) {
      const auto blood = static_cast<double>(count_label(labels, p, k, kLabelLvBlood));
      volume[p] += blood;
      if (blood > 0 && step * (k - end_k[p]) > 0) end_k[p] = k;
    }
    end_k[p] += 0.5 * step;
  }
  double mean_volume = 0;
  double mean_k = 0;
  for (std::size_t p = 0; p < n; ++p) {
    mean_volume += volume[p] / static_cast<double>(n);
    mean_k += end_k[p] / static_cast<double>(n);
  }
  double square = 0;
  double product = 0;
  for (std::size_t p = 0; p < n; ++p) {
    square += (volume[p] - mean_volume) * (volume[p] - mean_volume);
    product += (volume[p] - mean_volume) * (end_k[p] - mean_k);
  }
  // The plane descends as the ventricle empties, never the other way.
  const double slope = square > 0 ? step * std::max(0.0, step * product / square) : 0;
  std::vector<double> plane(n);
  for (std::size_t p = 0; p < n; ++p) plane[p] = mean_k + slope * (volume[p] - mean_volume);
  return plane;
}

}  // namespace

std::map<Structure, BaseCut> part_ventricles_from_atria(ImageCycle<std::uint8_t>& labels,
                                                        const Chambers& chambers,
                                                        const ValveOptions& options) {
  std::map<Structure, BaseCut> cuts;
  const Grid& grid = labels.grid;
  const double slice_mm = grid.spacing_mm()[2];
  if (!chambers.found_lv() || slice_mm < kThickSlicesMm) return cuts;
  const int step = chambers.base_step;
  const int base_k = step > 0 ? chambers.lv.back().k : chambers.lv.front().k;
  const int beyond = base_k + step;
  const auto n = static_cast<std::size_t>(labels.phase_count());
  if (beyond < 0 || beyond >= grid.size[2]) return cuts;
  if (cv::countNonZero(chambers.always_blood_moving[static_cast<std::size_t>(beyond)]) == 0) {
    // No atrium shows: the LV goes as far as its label does, phase by phase.
    const BaseCut moving{step, plane_of_labels(labels, base_k, step)};
    cuts[Structure::LvBlood] = moving;
    cuts[Structure::LvMyocardium] = moving;
    return cuts;
  }
  // The LV ends flat at its valve plane, somewhere in the gap: the middle is the fair guess.
  const BaseCut flat{step, std::vector<double>(n, base_k + 0.5 * step)};
  cuts[Structure::LvBlood] = flat;
  cuts[Structure::LvMyocardium] = flat;
  for (int k = beyond; k >= 0 && k < grid.size[2]; k += step) {
    const std::size_t begin = grid.offset(0, 0, k);
    for (std::vector<std::uint8_t>& phase : labels.phases) {
      for (std::size_t v = begin; v < begin + grid.slice_count(); ++v) {
        if (phase[v] != kLabelBackground) phase[v] = kLabelRestOfHeart;
      }
    }
  }

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
      options.tricuspid_excursion_mm * std::min(1.3, lv_slices * slice_mm / options.lv_length_mm);
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
