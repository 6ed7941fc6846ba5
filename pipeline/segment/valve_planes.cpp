#include "pipeline/segment/valve_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/core/lv_direction.h"

namespace beatlas::segment {
namespace {

/// Of a base in a beat: TAPSE is up to 30 mm, Rudski 2010, doi:10.1016/j.echo.2010.05.010.
constexpr double kMostDescentMm = 30;
constexpr int kLines = 120;      ///< that are tried, of ends at end-systole and of descents
constexpr double kSlack = 0.05;  ///< [slices x phases] beyond what labels tell, to a weight of 1/e

/// LV blood of each phase in voxels.
std::vector<double> lv_voxels(const ImageCycle<std::uint8_t>& labels) {
  std::vector<double> volume;
  for (const std::vector<std::uint8_t>& phase : labels.phases) {
    volume.push_back(static_cast<double>(std::count(phase.begin(), phase.end(), kLabelLvBlood)));
  }
  return volume;
}

/// Flat ends of each phase. A base that descends through a stack of thick slices does so in leaps
/// of whole slices: all that labels tell is between which two slices it lies. It descends with the
/// LV's volume, so of the straight lines in that volume, whose descent may be anything up to
/// kMostDescentMm, the mean is taken, weighed by how far each leaves what the labels tell.
std::vector<double> plane_places(const ImageCycle<std::uint8_t>& labels, Structure structure,
                                 int step, const std::vector<double>& lv_volume) {
  const auto n = static_cast<std::size_t>(labels.phase_count());
  std::vector<double> ends(n);  // midway between the two slices
  for (std::size_t p = 0; p < n; ++p) {
    const int k = most_basal(labels, p, structure, step);
    ends[p] = k < 0 ? (step > 0 ? labels.grid.size[2] : -1) : k + 0.5 * step;
  }
  const auto [least, most] = std::minmax_element(lv_volume.begin(), lv_volume.end());
  std::vector<double> filled(n, 0);  // 0 at end-systole, 1 at end-diastole
  if (*most > *least) {
    for (std::size_t p = 0; p < n; ++p) filled[p] = (lv_volume[p] - *least) / (*most - *least);
  }
  struct Line {
    double empty = 0;
    double full = 0;
    double beyond = 0;  ///< what labels tell [slices x phases]
  };
  std::vector<Line> lines;
  const auto [low, high] = std::minmax_element(ends.begin(), ends.end());
  const double descent = kMostDescentMm / labels.grid.spacing_mm()[2];
  double nearest = std::numeric_limits<double>::max();
  for (int i = 0; i <= kLines; ++i) {
    for (int j = 0; j <= kLines; ++j) {
      Line line;
      line.empty = *low - 1 + (*high - *low + 2) * i / kLines;
      line.full = line.empty + step * descent * j / kLines;
      for (std::size_t p = 0; p < n; ++p) {
        const double end = line.empty + (line.full - line.empty) * filled[p];
        line.beyond += std::max(0.0, std::abs(end - ends[p]) - 0.5);
      }
      nearest = std::min(nearest, line.beyond);
      lines.push_back(line);
    }
  }
  double weights = 0;
  double empty_end = 0;
  double full_end = 0;
  for (const Line& line : lines) {
    const double weight = std::exp((nearest - line.beyond) / kSlack);
    weights += weight;
    empty_end += weight * line.empty;
    full_end += weight * line.full;
  }
  for (std::size_t p = 0; p < n; ++p) {
    const double line = (empty_end + (full_end - empty_end) * filled[p]) / weights;
    ends[p] = std::clamp(line, ends[p] - 0.5, ends[p] + 0.5);
  }
  return ends;
}

/// +1 if the LV's cavity (without one, the heart) is larger towards larger k, where the base is
/// then, -1 if smaller; 0: neither.
int step_by_size(const LabelCycle& labels) {
  const Grid& grid = labels.grid;
  const auto size = [&](int k, bool (*inside)(std::uint8_t)) {
    std::ptrdiff_t count = 0;
    for (const std::vector<std::uint8_t>& phase : labels.phases) {
      const auto from = phase.begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
      count += std::count_if(from, from + static_cast<std::ptrdiff_t>(grid.slice_count()), inside);
    }
    return count;
  };
  const auto step_by = [&](bool (*inside)(std::uint8_t)) {
    std::vector<std::ptrdiff_t> sizes;
    for (int k = 0; k < grid.size[2]; ++k) {
      if (const std::ptrdiff_t here = size(k, inside); here > 0) sizes.push_back(here);
    }
    std::ptrdiff_t more = 0;  // of the upper half
    for (std::size_t s = 0; s < sizes.size() / 2; ++s) {
      more += sizes[sizes.size() - 1 - s] - sizes[s];
    }
    return more > 0 ? 1 : more < 0 ? -1 : 0;
  };
  const int by_cavity = step_by([](std::uint8_t label) { return label == kLabelLvBlood; });
  return by_cavity != 0 ? by_cavity : step_by([](std::uint8_t label) { return label != 0; });
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

std::map<Structure, ValvePlane> estimated_valve_planes(const ImageCycle<std::uint8_t>& labels,
                                                       int base_step) {
  const std::vector<double> lv_volume = lv_voxels(labels);
  std::map<Structure, ValvePlane> planes;
  for (Structure structure : kVentricular) {
    planes[structure] = {base_step, plane_places(labels, structure, base_step, lv_volume)};
  }
  return planes;
}

BaseSide base_side(const LabelCycle& labels) {
  const std::size_t slice = labels.grid.slice_count();
  double beyond = 0;
  double beyond_k = 0;
  double ventricle = 0;
  double ventricle_k = 0;
  std::vector<float> blood(labels.grid.count(), 0.0F);
  std::vector<float> muscle(labels.grid.count(), 0.0F);
  const auto each = 1.0F / static_cast<float>(labels.phases.size());
  for (const std::vector<std::uint8_t>& phase : labels.phases) {
    for (std::size_t v = 0; v < phase.size(); ++v) {
      const std::size_t of_slice = v / slice;
      const auto k = static_cast<double>(of_slice);
      if (phase[v] == kLabelLvMyocardium) muscle[v] += each;
      if (phase[v] == kLabelLvBlood) {
        blood[v] += each;
        ventricle += 1;
        ventricle_k += k;
      }
      if (phase[v] == kLabelLaBlood || phase[v] == kLabelRaBlood || phase[v] == kLabelAorta) {
        beyond += 1;
        beyond_k += k;
      }
    }
  }
  BaseSide out{.step = 0, .across = true};
  if (const std::optional<Vec3> direction = lv_direction(labels.grid, blood, muscle)) {
    const Vec3 steps = labels.grid.mm_from_index.linear().inverse() * *direction;
    out.step = steps[2] < 0 ? -1 : 1;
    out.across = cuts_across(labels.grid, *direction);
  }
  constexpr double kStray = 0.05;  // of the LV: a few voxels tell nothing
  if (beyond > kStray * ventricle && ventricle > 0) {
    out.step = beyond_k / beyond < ventricle_k / ventricle ? -1 : 1;
  }
  if (out.step == 0) out.step = step_by_size(labels);
  return out;
}

}  // namespace beatlas::segment
