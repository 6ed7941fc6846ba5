#pragma once
#include "pipeline/field/interpolant.h"

namespace beatlas::mesh {

/// Where along a ray the distance changes its sign between two places that have different ones, to
/// 1e-4 mm. @param along of unit length @return [mm] from `from`, low..high
[[nodiscard]] inline double zero_between(const field::Interpolant& distance, const Vec3& from,
                                         const Vec3& along, double low, double high) {
  const bool low_inside = distance.value(from + low * along) < 0;
  while (high - low > 1e-4) {
    const double middle = 0.5 * (low + high);
    ((distance.value(from + middle * along) < 0) == low_inside ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace beatlas::mesh
