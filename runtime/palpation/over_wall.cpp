#include "runtime/palpation/over_wall.h"

#include <algorithm>

#include "runtime/palpation/atlas_muscle.h"

namespace beatlas::palpation {

std::optional<Vec3> over_wall(const LvWall& wall, std::uint32_t vertex,
                              const field::FieldQuery& heart, double end_diastole_s) {
  constexpr double kStepMm = 0.5;
  constexpr double kExactMm = 1e-6;
  const Vec3 from = wall.mm(vertex);
  const Vec3& outward = wall.outward(vertex);
  const auto wall_mm = static_cast<double>(wall.wall_mm()[vertex]);
  const auto inside = [&](double way) {
    return heart.sample(from + way * outward, end_diastole_s).distance_mm < 0;
  };
  double way = 0;
  while (inside(way)) {
    way += kStepMm;
    if (way > wall_mm + AtlasMuscle::kOutsideMm) return std::nullopt;
  }
  double low = std::max(0.0, way - kStepMm);
  double high = way;
  while (high - low > kExactMm) {
    const double half = 0.5 * (low + high);
    (inside(half) ? low : high) = half;
  }
  return from + high * outward;
}

}  // namespace beatlas::palpation
