#include "pipeline/core/segmented_volume.h"

#include <algorithm>
#include <numeric>

#include "pipeline/core/parallel.h"

namespace beatlas {

double share_within_cut(const Segmentation& segmentation, Structure structure, int phase, int k) {
  const auto found = segmentation.base_cuts.find(structure);
  if (found == segmentation.base_cuts.end()) return 1;
  const double plane = found->second.k[static_cast<std::size_t>(phase)];
  const double inside = found->second.base_step > 0 ? plane - (k - 0.5) : (k + 0.5) - plane;
  return std::clamp(inside, 0.0, 1.0);
}

std::vector<double> segmented_volume_ml(const Segmentation& segmentation, Structure structure) {
  std::vector<double> curve;
  const CoverageCycle& coverage = segmentation.coverage;
  const auto found = coverage.phases.find(structure);
  if (found == coverage.phases.end()) return curve;
  const auto slice = static_cast<std::ptrdiff_t>(coverage.grid.slice_count());
  curve.resize(found->second.size());
  parallel_for(curve.size(), [&](std::size_t phase) {
    double sum = 0;
    for (int k = 0; k < coverage.grid.size[2]; ++k) {
      const auto first = found->second[phase].begin() + slice * k;
      sum += share_within_cut(segmentation, structure, static_cast<int>(phase),
                              k + coverage.first[2]) *
             std::accumulate(first, first + slice, 0.0);
    }
    curve[phase] = sum * coverage.grid.voxel_ml();
  });
  return curve;
}

}  // namespace beatlas
