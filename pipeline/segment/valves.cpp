#include "pipeline/segment/valves.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <opencv2/imgproc.hpp>

#include "pipeline/segment/base_plane.h"
#include "pipeline/segment/long_axis_views.h"
#include "pipeline/segment/seeds.h"

namespace beatlas::segment {
namespace {

const std::vector<std::uint8_t> kLv{kLabelLvBlood, kLabelLvMyocardium};
const std::vector<std::uint8_t> kRv{kLabelRvBlood};
constexpr double kLeastRing = 0.5;  ///< of the rays: what technicians ask for
constexpr double kAtrialWallMm = 3;
constexpr double kAtrialPoolMm2 =
    300;  ///< a smaller pool beyond the base is a vessel or a rest of LV

std::size_t count_label(const ImageCycle<std::uint8_t>& labels, std::size_t phase, int k,
                        std::uint8_t label) {
  const auto from =
      labels.phases[phase].begin() + static_cast<std::ptrdiff_t>(labels.grid.offset(0, 0, k));
  return static_cast<std::size_t>(
      std::count(from, from + static_cast<std::ptrdiff_t>(labels.grid.slice_count()), label));
}

int drawn_at(const std::vector<int>& drawn_k, std::size_t phase) {
  return drawn_k.empty() ? -1 : drawn_k[phase];
}

/// A basal slice that the LV leaves in systole shows the atrium then: blood without a ring of
/// muscle.
void drop_unringed_base(ImageCycle<std::uint8_t>& labels, const Chambers& chambers,
                        const std::vector<int>& drawn_k) {
  const Grid& grid = labels.grid;
  const std::size_t slices = chambers.lv.size();
  for (std::size_t p = 0; p < labels.phases.size(); ++p) {
    for (std::size_t s = 0; s + 1 < slices; ++s) {
      const LvSlice& slice = chambers.lv[chambers.base_step > 0 ? slices - 1 - s : s];
      if (slice.rings[p].muscle_share() >= kLeastRing || slice.k == drawn_at(drawn_k, p)) break;
      const std::size_t begin = grid.offset(0, 0, slice.k);
      for (std::size_t v = begin; v < begin + grid.slice_count(); ++v) {
        std::uint8_t& label = labels.phases[p][v];
        if (label == kLabelLvBlood || label == kLabelLvMyocardium) label = kLabelRestOfHeart;
      }
    }
  }
}

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

/// What lies beyond the plane of its phase, slice by slice, becomes the rest of the heart.
void end_at(ImageCycle<std::uint8_t>& labels, const std::vector<std::uint8_t>& of,
            const std::vector<double>& plane_k, int step) {
  const Grid& grid = labels.grid;
  for (std::size_t p = 0; p < labels.phases.size(); ++p) {
    for (int k = 0; k < grid.size[2]; ++k) {
      if (step * (k - plane_k[p]) <= 0) continue;
      const std::size_t begin = grid.offset(0, 0, k);
      for (std::size_t v = begin; v < begin + grid.slice_count(); ++v) {
        std::uint8_t& label = labels.phases[p][v];
        if (std::find(of.begin(), of.end(), label) != of.end()) label = kLabelRestOfHeart;
      }
    }
  }
}

/// The cavity does not reach slices beyond its apical end: that is muscle.
void close_at_apex(ImageCycle<std::uint8_t>& labels, const std::vector<double>& apex_k, int step) {
  const Grid& grid = labels.grid;
  for (std::size_t p = 0; p < labels.phases.size(); ++p) {
    for (int k = 0; k < grid.size[2]; ++k) {
      if (step * (k - apex_k[p]) >= 0) continue;
      const auto begin =
          labels.phases[p].begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
      std::replace(begin, begin + static_cast<std::ptrdiff_t>(grid.slice_count()), kLabelLvBlood,
                   kLabelLvMyocardium);
    }
  }
}

std::vector<double> reaching(std::vector<double> planes_k, const std::vector<int>& drawn_k,
                             int step) {
  for (std::size_t p = 0; p < planes_k.size(); ++p) {
    planes_k[p] = segment::reaching(planes_k[p], drawn_at(drawn_k, p), step);
  }
  return planes_k;
}

int base_slice(const Chambers& chambers) {
  return chambers.base_step > 0 ? chambers.lv.back().k : chambers.lv.front().k;
}

/// Whether a beating pool lies beyond the LV's most basal slice.
bool atria_beyond(const Grid& grid, const Chambers& chambers) {
  const int beyond = base_slice(chambers) + chambers.base_step;
  if (beyond < 0 || beyond >= grid.size[2]) return false;
  const Vec3 spacing = grid.spacing_mm();
  return cv::countNonZero(chambers.always_blood_moving[static_cast<std::size_t>(beyond)]) *
             spacing[0] * spacing[1] >=
         kAtrialPoolMm2;
}

/// No ventricle beyond the LV's most basal slice, but where one was drawn.
void end_at_last_slice(ImageCycle<std::uint8_t>& labels, const Chambers& chambers,
                       const DrawnReach& drawn) {
  const int step = chambers.base_step;
  const std::vector<double> last(labels.phases.size(), base_slice(chambers) + 0.5 * step);
  end_at(labels, kLv, reaching(last, drawn.lv_base, step), step);
  end_at(labels, kRv, reaching(last, drawn.rv_base, step), step);
}

/// The tricuspid plane lies with the mitral one where that is highest, and descends with it.
std::vector<double> tricuspid_beside(const std::vector<double>& mitral_k,
                                     const std::vector<int>& lv_slices, int step, double slice_mm,
                                     double tricuspid_excursion_mm) {
  const auto [low, high] = std::minmax_element(mitral_k.begin(), mitral_k.end());
  const double top = step > 0 ? *high : *low;
  const double range = *high - *low;
  const int apical = step > 0 ? lv_slices.front() : lv_slices.back();
  const double scale = std::min(1.3, std::abs(top - apical) * slice_mm / kLvLengthMm);
  std::vector<double> ends;
  for (const double k : mitral_k) {
    const double loss = range > 0 ? std::abs(top - k) / range : 0;
    ends.push_back(top - step * loss * scale * tricuspid_excursion_mm / slice_mm);
  }
  return ends;
}

/// Slice index of the tricuspid plane in every phase; empty if there is no RV or it does not beat.
std::vector<double> tricuspid_by_rule(const ImageCycle<std::uint8_t>& labels,
                                      const Chambers& chambers, double tricuspid_excursion_mm) {
  const double slice_mm = labels.grid.spacing_mm()[2];
  const int step = chambers.base_step;
  const auto ed = static_cast<std::size_t>(chambers.end_diastole);
  int lv_slices = 0;
  for (int k = 0; k < labels.grid.size[2]; ++k) {
    lv_slices += count_label(labels, ed, k, kLabelLvMyocardium) > 0 ? 1 : 0;
  }
  const int rv_base_k = most_basal(labels, ed, Structure::RvBlood, step);
  const std::vector<double> lv_volume = lv_voxels(labels);
  const auto [least, most] = std::minmax_element(lv_volume.begin(), lv_volume.end());
  std::vector<double> ends;
  if (rv_base_k < 0 || *most <= *least) return ends;
  const double excursion_mm =
      tricuspid_excursion_mm * std::min(1.3, lv_slices * slice_mm / kLvLengthMm);
  for (const double volume : lv_volume) {
    const double loss = (*most - volume) / (*most - *least);
    ends.push_back(rv_base_k + step * (0.5 - loss * excursion_mm / slice_mm));
  }
  return ends;
}

}  // namespace

double reaching(double plane_k, int drawn_k, int step) {
  return drawn_k >= 0 && step * (drawn_k - plane_k) > 0 ? drawn_k + 0.5 * step : plane_k;
}

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

VentricleEnds find_ventricle_ends(const ImageCycle<float>& images, const std::vector<Cine>& views,
                                  const ImageCycle<std::uint8_t>& labels, const Chambers& chambers,
                                  double tricuspid_excursion_mm) {
  VentricleEnds ends;
  if (!chambers.found_lv() || labels.grid.spacing_mm()[2] < kThickSlicesMm) return ends;
  ViewSearch in_views{views, labels, {}, chambers.base_step, chambers.end_diastole};
  for (const LvSlice& slice : chambers.lv) in_views.lv_slices.push_back(slice.k);
  std::optional<LvEndsInViews> seen = find_lv_ends_in_views(in_views, ends.trouble);
  const BasePlaneSearch search{images,
                               labels,
                               chambers.lv[chambers.lv.size() / 2].k,
                               chambers.base_step,
                               chambers.levels.blood - chambers.levels.muscle,
                               chambers.levels.threshold};
  if (seen) {
    ends.from_views = true;
    ends.lv = std::move(seen->base_k);
    if (!seen->apex_k.empty()) ends.lv_apex = std::move(seen->apex_k);
  } else {
    ends.lv = base_plane_by_mixture(search, kLv, false);
  }
  ends.rv = base_plane_by_mixture(search, kRv, true);
  if (seen && !ends.rv) {
    ends.rv = tricuspid_beside(*ends.lv, in_views.lv_slices, chambers.base_step,
                               labels.grid.spacing_mm()[2], tricuspid_excursion_mm);
  }
  return ends;
}

void wall_atria(const ImageCycle<float>& images, const Chambers& chambers,
                const VentricleEnds& ends, ImageCycle<std::uint8_t>& labels) {
  if (!ends.lv) return;
  const Grid& grid = labels.grid;
  const Vec3 spacing = grid.spacing_mm();
  const cv::Mat reach = disc(kAtrialWallMm, {spacing[0], spacing[1]});
  for (std::size_t p = 0; p < labels.phases.size(); ++p) {
    for (int k = 0; k < grid.size[2]; ++k) {
      if (chambers.base_step * (k - (*ends.lv)[p]) <= 0) continue;
      cv::Mat slice = slice_of(grid, labels.phases[p], k);
      cv::Mat near;
      cv::dilate(slice != kLabelBackground, near, reach);
      const cv::Mat image = slice_of(grid, images.phases[p], k);
      const cv::Mat muscle = (image > chambers.levels.dark) & (image < chambers.levels.threshold);
      slice.setTo(cv::Scalar(kLabelRestOfHeart), near & muscle & (slice == kLabelBackground));
    }
  }
}

std::map<Structure, BaseCut> part_ventricles_from_atria(ImageCycle<std::uint8_t>& labels,
                                                        const Chambers& chambers,
                                                        const VentricleEnds& ends,
                                                        double tricuspid_excursion_mm) {
  if (!chambers.found_lv() || labels.grid.spacing_mm()[2] < kThickSlicesMm) return {};
  const int step = chambers.base_step;
  if (ends.lv_apex) close_at_apex(labels, *ends.lv_apex, step);
  if (ends.lv) {
    end_at(labels, kLv, *ends.lv, step);
  } else {
    if (atria_beyond(labels.grid, chambers)) end_at_last_slice(labels, chambers, ends.drawn);
    drop_unringed_base(labels, chambers, ends.drawn.lv_base);
  }
  if (ends.rv) end_at(labels, kRv, *ends.rv, step);
  std::map<Structure, BaseCut> cuts = flat_base_cuts(labels, step);
  if (ends.lv) {
    cuts[Structure::LvBlood] = {step, *ends.lv};
    cuts[Structure::LvMyocardium] = {step, *ends.lv};
  }
  if (ends.rv) {
    cuts[Structure::RvBlood] = {step, *ends.rv};
  } else if (ends.lv || atria_beyond(labels.grid, chambers)) {
    const std::vector<double> by_rule = reaching(
        tricuspid_by_rule(labels, chambers, tricuspid_excursion_mm), ends.drawn.rv_base, step);
    if (!by_rule.empty()) {
      end_at(labels, kRv, by_rule, step);
      cuts[Structure::RvBlood] = {step, by_rule};
    }
  }
  return cuts;
}

}  // namespace beatlas::segment
