#include "pipeline/identify/elastogram.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "runtime/base/error.h"
#include "runtime/palpation/measured.h"

namespace beatlas::identify {
namespace {

constexpr double kBesideEdges = 0.125;  // of the thickness: there voxels hold blood and fat as well
constexpr double kLeastShare = 0.05;    // of the wall; one slice of an elastogram is more

/// Trilinear between measured voxels alone; 0 where those count less than half.
double measured_at(const Grid& grid, const std::vector<float>& image, const Vec3& index) {
  const Vec3 floor = index.array().floor();
  double sum = 0;
  double weight = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Index3 at{};
    double share = 1;
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
      const int up = (corner >> a) & 1;
      const double part = index[a] - floor[a];
      at[a] = static_cast<int>(floor[a]) + up;
      share *= up == 1 ? part : 1 - part;
      inside = inside && at[a] >= 0 && at[a] < grid.size[a];
    }
    if (!inside || share <= 0) continue;
    const float value = image[grid.offset(at[0], at[1], at[2])];
    if (!(value > 0)) continue;
    sum += share * static_cast<double>(value);
    weight += share;
  }
  return weight >= 0.5 ? sum / weight : 0;
}

}  // namespace

std::vector<float> elastogram_of_wall(const palpation::LvWall& wall,
                                      const Affine& workspace_from_lps, const Grid& grid,
                                      const std::vector<float>& image,
                                      const ElastogramOptions& options) {
  const Affine index_from_workspace =
      grid.mm_from_index.inverse(Eigen::Affine) * workspace_from_lps.inverse(Eigen::Isometry);
  const double step_mm = 0.5 * grid.spacing_mm().minCoeff();
  const double scale = options.kpa_per_unit * (options.modulus == Modulus::Shear ? 3 : 1);
  std::vector<float> out(wall.vertex_count());
  std::vector<float> all;
  std::size_t walls = 0;
  for (std::uint32_t v = 0; v < out.size(); ++v) {
    const auto thick = static_cast<double>(wall.wall_mm()[v]);
    if (!(thick > 0)) continue;
    ++walls;
    const double way_mm = (1 - 2 * kBesideEdges) * thick;
    const int steps = std::clamp(static_cast<int>(std::ceil(way_mm / step_mm)), 2, 200);
    double sum = 0;
    int measured = 0;
    for (int n = 0; n <= steps; ++n) {
      const double deep_mm = kBesideEdges * thick + way_mm * n / steps;
      const double value =
          measured_at(grid, image, index_from_workspace * (wall.mm(v) + deep_mm * wall.outward(v)));
      if (!(value > 0)) continue;
      sum += value;
      ++measured;
    }
    if (2 * measured < steps + 1) continue;
    out[v] = static_cast<float>(scale * sum / measured);
    all.push_back(out[v]);
  }
  if (static_cast<double>(all.size()) < kLeastShare * static_cast<double>(walls)) {
    throw_invalid("it measures " + std::to_string(all.size()) + " of " + std::to_string(walls) +
                  " places of the LV's wall at end-diastole; is it an image of this heart, in the "
                  "frame of its exam?");
  }
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  if (!(*middle >= palpation::kLeastKpa && *middle <= palpation::kMostKpa)) {
    std::array<char, 32> median{};
    std::snprintf(median.data(), median.size(), "%.3g", static_cast<double>(*middle));
    throw_invalid(std::string("the median of the wall would be ") + median.data() +
                  " kPa, where myocardium has 1 to some 100; say its unit by --unit kpa or pa");
  }
  return out;
}

}  // namespace beatlas::identify
