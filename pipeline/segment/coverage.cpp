#include "pipeline/segment/coverage.h"

#include <algorithm>
#include <numeric>

#include "pipeline/core/parallel.h"
#include "pipeline/core/segmented_volume.h"
#include "pipeline/segment/boundary.h"
#include "pipeline/segment/segment.h"

namespace beatlas::segment {
namespace {

/// Myocardium is what lies around the cavity: where both touch, their shares make one voxel.
void share_wall(const std::vector<std::uint8_t>& labels, const std::vector<float>& blood,
                std::vector<float>& myocardium) {
  for (std::size_t v = 0; v < labels.size(); ++v) {
    const float b = blood[v];
    if (!(b > 0)) continue;
    if (labels[v] == kLabelLvBlood) myocardium[v] = 1 - b;
    if (labels[v] == kLabelLvMyocardium) myocardium[v] = std::min(myocardium[v], 1 - b);
  }
}

}  // namespace

std::vector<std::uint8_t> where(const std::vector<std::uint8_t>& labels, Structure structure) {
  std::vector<std::uint8_t> mask(labels.size());
  std::transform(labels.begin(), labels.end(), mask.begin(), [&](std::uint8_t label) {
    return static_cast<std::uint8_t>(label_in_structure(label, structure));
  });
  return mask;
}

CoverageCycle cover(const ImageCycle<float>& images, const ImageCycle<std::uint8_t>& labels,
                    const Box& box, const TissueLevels& levels, double noise) {
  CoverageCycle out;
  out.grid = images.grid;
  out.first = box.first;
  const auto n = static_cast<std::size_t>(images.phase_count());
  const double contrast = std::max(2.5 * noise, 0.08 * (levels.blood - levels.muscle));
  for (Structure structure : kAllStructures) {
    std::vector<std::vector<float>>& phases = out.phases[structure];
    phases.resize(n);
    parallel_for(n, [&](std::size_t p) {
      const std::vector<std::uint8_t> inside = where(labels.phases[p], structure);
      std::vector<std::uint8_t> reference = inside;
      if (structure == Structure::Heart && levels.muscle > 0) {
        // Under the outer surface lies muscle; blood behind a thin wall must not tell its level.
        for (std::size_t v = 0; v < reference.size(); ++v) {
          reference[v] =
              static_cast<std::uint8_t>(inside[v] && images.phases[p][v] < levels.threshold);
        }
      }
      phases[p] = boundary_coverage(images.grid, images.phases[p], inside, reference, contrast);
    });
    const bool empty = std::all_of(phases.begin(), phases.end(), [](const auto& phase) {
      return std::none_of(phase.begin(), phase.end(), [](float c) { return c >= 0.5F; });
    });
    if (empty) out.phases.erase(structure);
  }
  const auto myocardium = out.phases.find(Structure::LvMyocardium);
  const auto blood = out.phases.find(Structure::LvBlood);
  if (myocardium != out.phases.end() && blood != out.phases.end()) {
    for (std::size_t p = 0; p < n; ++p) {
      share_wall(labels.phases[p], blood->second[p], myocardium->second[p]);
    }
  }
  return out;
}

std::vector<double> volume_curve_ml(const CoverageCycle& coverage, Structure structure) {
  std::vector<double> curve;
  const auto found = coverage.phases.find(structure);
  if (found == coverage.phases.end()) return curve;
  for (const std::vector<float>& phase : found->second) {
    curve.push_back(std::accumulate(phase.begin(), phase.end(), 0.0) * coverage.grid.voxel_ml());
  }
  return curve;
}

void find_ends(Segmentation& segmentation) {
  const std::vector<double> curve = segmented_volume_ml(
      segmentation, segmentation.coverage.phases.count(Structure::LvBlood) != 0 ? Structure::LvBlood
                                                                                : Structure::Heart);
  segmentation.end_diastole =
      static_cast<int>(std::max_element(curve.begin(), curve.end()) - curve.begin());
  segmentation.end_systole =
      static_cast<int>(std::min_element(curve.begin(), curve.end()) - curve.begin());
}

}  // namespace beatlas::segment
