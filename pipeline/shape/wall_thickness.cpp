#include "pipeline/shape/wall_thickness.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

namespace beatlas::shape {

std::optional<double> wall_thickness_mm(const CoverageCycle& coverage) {
  const auto blood = coverage.phases.find(Structure::LvBlood);
  const auto muscle = coverage.phases.find(Structure::LvMyocardium);
  if (blood == coverage.phases.end() || muscle == coverage.phases.end()) return {};
  const Vec3 spacing = coverage.grid.spacing_mm();
  const auto voxels = static_cast<std::ptrdiff_t>(coverage.grid.slice_count());
  const auto area_mm2 = [&](const std::vector<float>& share, int k) {
    const auto from = share.begin() + k * voxels;
    return std::accumulate(from, from + voxels, 0.0) * spacing.x() * spacing.y();
  };
  std::vector<double> widths;
  for (std::size_t p = 0; p < muscle->second.size(); ++p) {
    for (int k = 0; k < coverage.grid.size[2]; ++k) {
      const double inner = area_mm2(blood->second[p], k);
      const double ring = area_mm2(muscle->second[p], k);
      if (!(inner > 0) || !(ring > 0)) continue;
      widths.push_back((std::sqrt(inner + ring) - std::sqrt(inner)) / std::sqrt(std::numbers::pi));
    }
  }
  if (widths.empty()) return {};
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  return *middle;
}

}  // namespace beatlas::shape
