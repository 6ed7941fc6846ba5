#include "runtime/palpation/measured.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "runtime/base/error.h"

namespace beatlas::palpation {

std::vector<float> kpa_of_wall(const LvWall& wall, const std::vector<MeasuredPoint>& points,
                               double reach_mm) {
  constexpr double kBesideMm2 = 1;  // a point that lies at a vertex is not all that counts there
  const std::size_t count = wall.vertex_count();
  std::vector<double> weight(count);
  std::vector<double> sum(count);
  for (std::size_t n = 0; n < points.size(); ++n) {
    double nearest2 = std::numeric_limits<double>::infinity();
    for (std::uint32_t v = 0; v < count; ++v) {
      const auto thick = static_cast<double>(wall.wall_mm()[v]);
      if (!(thick > 0)) continue;
      const Vec3 middle = wall.mm(v) + 0.5 * thick * wall.outward(v);
      const double far2 = (points[n].mm - middle).squaredNorm();
      nearest2 = std::min(nearest2, far2);
      if (far2 > reach_mm * reach_mm) continue;
      const double counts = 1 / (far2 + kBesideMm2);
      weight[v] += counts;
      sum[v] += counts * points[n].kpa;
    }
    if (!(nearest2 <= reach_mm * reach_mm)) {
      throw_invalid("point " + std::to_string(n + 1) + " lies " +
                    std::to_string(std::lround(std::sqrt(nearest2))) +
                    " mm from the LV's muscle at end-diastole, and reaches " +
                    std::to_string(std::lround(reach_mm)) +
                    " mm; is it a point of this heart, in mm of the patient's frame (LPS)?");
    }
  }
  std::vector<float> out(count);
  for (std::size_t v = 0; v < count; ++v) {
    if (weight[v] > 0) out[v] = static_cast<float>(sum[v] / weight[v]);
  }
  return out;
}

}  // namespace beatlas::palpation
