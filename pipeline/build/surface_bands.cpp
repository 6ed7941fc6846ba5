#include "pipeline/build/surface_bands.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "pipeline/report/prediction_intervals.h"

namespace beatlas::build {
namespace {

/// What a band's half width is made of.
struct BandModel {
  Structure structure;
  double own_mm;    ///< within slices, whatever the prior doubts
  double of_doubt;  ///< within slices, times how far off the prior expects the outline to be
  /// Shares of the slices' distance, where a surface lies flat in them: between the structure's
  /// last slices, at that toward the base and at that toward the apex.
  double middle;
  double base;
  double apex;
};

/// Printed by `scripts/fit_bands`, of 52 drawn hearts (`scripts/score_draws --surfaces`, seeds 9000
/// to 9028 and 9200 to 9227). The distance to the nearest slice did not improve the fit within
/// slices.
constexpr std::array<BandModel, 4> kModels{{
    {Structure::Heart, 0.000, 1.236, 0.362, 2.013, 0.721},
    {Structure::LvBlood, 0.666, 1.179, 0.314, 0.907, 0.447},
    {Structure::RvBlood, 0.000, 1.114, 0.358, 1.375, 0.355},
    {Structure::LvMyocardium, 0.929, 0.420, 0.210, 0.713, 0.459},
}};

/// [mm] How far off the outline of a slice is likely to lie, in the mean over it.
double expected_error_mm(const SliceBelief& slice) {
  const double larger_mm2 = std::max(slice.labelled_mm2, slice.expected_mm2);
  if (larger_mm2 <= 0) return 0;
  const double differs_mm2 = slice.labelled_mm2 + slice.expected_mm2 - 2 * slice.agreed_mm2;
  return std::max(0.0, differs_mm2) / (2 * std::sqrt(std::numbers::pi * larger_mm2));
}

/// As far as a package may tell it.
double rounded_mm(double mm) { return std::round(100 * std::min(mm, 1000.0)) / 100; }

/// Of all phases together.
bool is_mostly_told_through(const std::vector<std::vector<SliceBelief>>& phases) {
  std::vector<SliceBelief> all;
  for (const std::vector<SliceBelief>& slices : phases) {
    all.insert(all.end(), slices.begin(), slices.end());
  }
  return report::is_mostly_told(all);
}

/// See ValvePlane. @pre segmentation.axis
int base_step_of(const Segmentation& segmentation) {
  const Vec3 step = segmentation.labels.grid.mm_from_index.linear().col(2);
  return segmentation.axis->towards_base.dot(step) > 0 ? 1 : -1;
}

/// [phase][slice] within slices. Where a person told what a slice holds, no prior tells how well:
/// it counts as the structure's worst one.
/// @param least_mm half of a pixel, nearer than which no outline is known
std::vector<std::vector<double>> across_mm(const BandModel& model,
                                           const std::vector<std::vector<SliceBelief>>& phases,
                                           double least_mm) {
  std::vector<std::vector<double>> out;
  double widest_mm = 0;
  for (const std::vector<SliceBelief>& slices : phases) {
    std::vector<double>& across =
        out.emplace_back(slices.size(), rounded_mm(std::max(least_mm, model.own_mm)));
    for (const std::size_t k : slices_about_labels(slices)) {
      const double doubt_mm = model.of_doubt * expected_error_mm(slices[k]);
      across[k] = rounded_mm(std::max(least_mm, model.own_mm + doubt_mm));
      widest_mm = std::max(widest_mm, across[k]);
    }
  }
  for (std::size_t p = 0; p < phases.size(); ++p) {
    for (std::size_t k = 0; k < phases[p].size(); ++k) {
      if (phases[p][k].labelled_mm2 > 0 && phases[p][k].is_told()) out[p][k] = widest_mm;
    }
  }
  return out;
}

/// [slice] along the slices' normal, of one phase. @param base_step see ValvePlane
std::vector<double> along_mm(const BandModel& model, const std::vector<SliceBelief>& slices,
                             int base_step, double distance_mm) {
  const auto is_labelled = [](const SliceBelief& slice) { return slice.labelled_mm2 > 0; };
  const auto first = std::find_if(slices.begin(), slices.end(), is_labelled);
  const auto last = std::find_if(slices.rbegin(), slices.rend(), is_labelled);
  std::vector<double> out(slices.size(), rounded_mm(model.middle * distance_mm));
  if (first == slices.end()) return out;
  const double base_mm = rounded_mm(model.base * distance_mm);
  const double apex_mm = rounded_mm(model.apex * distance_mm);
  const std::ptrdiff_t low = first - slices.begin();
  const std::ptrdiff_t high = slices.rend() - last - 1;
  std::fill(out.begin(), out.begin() + low + 1, base_step < 0 ? base_mm : apex_mm);
  std::fill(out.begin() + high, out.end(), base_step < 0 ? apex_mm : base_mm);
  // A structure of one slice gets the wider of the two.
  if (low == high) out[static_cast<std::size_t>(low)] = std::max(base_mm, apex_mm);
  return out;
}

}  // namespace

std::map<Structure, atlas::SurfaceBand> surface_bands(const Segmentation& segmentation) {
  std::map<Structure, atlas::SurfaceBand> out;
  if (!segmentation.axis) return out;
  const Vec3 spacing_mm = segmentation.labels.grid.spacing_mm();
  for (const BandModel& model : kModels) {
    const auto found = segmentation.belief.find(model.structure);
    if (found == segmentation.belief.end() || is_mostly_told_through(found->second)) continue;
    atlas::SurfaceBand& band = out[model.structure];
    band.across_mm = across_mm(model, found->second, 0.5 * spacing_mm[0]);
    for (const std::vector<SliceBelief>& slices : found->second) {
      band.along_mm.push_back(along_mm(model, slices, base_step_of(segmentation), spacing_mm[2]));
    }
  }
  return out;
}

std::vector<report::KnownSurface> known_surfaces(const Segmentation& segmentation) {
  std::vector<report::KnownSurface> out;
  const auto phase = static_cast<std::size_t>(segmentation.end_diastole);
  for (const auto& [structure, band] : surface_bands(segmentation)) {
    const std::vector<SliceBelief>& slices = segmentation.belief.at(structure)[phase];
    std::vector<std::size_t> labelled;
    for (std::size_t k = 0; k < slices.size(); ++k) {
      if (slices[k].labelled_mm2 > 0) labelled.push_back(k);
    }
    if (labelled.empty() || report::is_mostly_told(slices)) continue;
    const bool base_first = base_step_of(segmentation) < 0;
    report::KnownSurface known{structure};
    known.at_base_mm = band.along_mm[phase][base_first ? labelled.front() : labelled.back()];
    known.at_apex_mm = band.along_mm[phase][base_first ? labelled.back() : labelled.front()];
    std::stable_sort(labelled.begin(), labelled.end(), [&](std::size_t a, std::size_t b) {
      return band.across_mm[phase][a] < band.across_mm[phase][b];
    });
    known.in_slices_mm = band.across_mm[phase][labelled[labelled.size() / 2]];
    known.worst_slice = static_cast<int>(labelled.back());
    known.worst_slice_mm = band.across_mm[phase][labelled.back()];
    out.push_back(known);
  }
  return out;
}

}  // namespace beatlas::build
