#include "pipeline/core/segmented_volume.h"

#include <algorithm>
#include <numeric>

#include "pipeline/core/parallel.h"

namespace beatlas {

std::vector<double> segmented_volume_ml(const Segmentation& segmentation, Structure structure) {
  std::vector<double> curve;
  const CoverageCycle& coverage = segmentation.coverage;
  const auto found = coverage.phases.find(structure);
  if (found == coverage.phases.end()) return curve;
  curve.resize(found->second.size());
  parallel_for(curve.size(), [&](std::size_t phase) {
    const std::vector<float>& covered = found->second[phase];
    curve[phase] = std::accumulate(covered.begin(), covered.end(), 0.0) * coverage.grid.voxel_ml();
  });
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

}  // namespace beatlas
