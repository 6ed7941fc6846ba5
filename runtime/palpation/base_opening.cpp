#include "runtime/palpation/base_opening.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "runtime/base/error.h"

namespace beatlas::palpation {
namespace {

constexpr float kBasalQuarter = 0.75F;  // of the long axis
constexpr double kPassable = 0.5;       // of the radius of a circle as large as the base
constexpr double kLeastRadiusMm = 2;    // of what anything could pass

}  // namespace

std::vector<haptics::Opening> base_opening(const atlas::SurfacePayload& endocardium,
                                           const atlas::SurfaceMapPayload& map) {
  const std::size_t phases = endocardium.positions.size();
  const std::size_t vertices = map.long_axis.size();
  if (phases == 0 || map.thickness_mm.size() != phases ||
      endocardium.positions.front().size() != vertices) {
    throw_invalid("the LV's surface and its map are not of one cycle");
  }
  std::vector<haptics::Opening> out;
  for (std::size_t p = 0; p < phases; ++p) {
    const std::vector<Vec3f>& x = endocardium.positions[p];
    const auto is_open = [&](std::uint32_t v) {
      return map.thickness_mm[p][v] <= 0 && map.long_axis[v] >= kBasalQuarter;
    };
    Vec3 area_mm2 = Vec3::Zero();
    Vec3 weighted = Vec3::Zero();
    double weight = 0;
    for (const auto& [a, b, c] : endocardium.triangles) {
      if (!is_open(a) || !is_open(b) || !is_open(c)) continue;
      const Vec3 first = x[a].cast<double>();
      const Vec3 second = x[b].cast<double>();
      const Vec3 third = x[c].cast<double>();
      const Vec3 own = 0.5 * (second - first).cross(third - first);
      area_mm2 += own;
      weighted += own.norm() * (first + second + third) / 3;
      weight += own.norm();
    }
    const double radius_mm = kPassable * std::sqrt(area_mm2.norm() / std::numbers::pi);
    if (!(radius_mm >= kLeastRadiusMm)) {
      throw_invalid("the left ventricle has no opening at its base in phase " + std::to_string(p) +
                    " through which a tool could pass");
    }
    out.push_back(
        {.centre_mm = weighted / weight, .normal = area_mm2.normalized(), .radius_mm = radius_mm});
  }
  return out;
}

}  // namespace beatlas::palpation
