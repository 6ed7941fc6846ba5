#include "pipeline/core/box_share.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace beatlas {
namespace {

double cube(double x) { return x > 0 ? x * x * x : 0; }

}  // namespace

double box_share(const Vec3& half_mm, double distance_mm, const Vec3& outward) {
  std::array<double, 3> m{};
  double total = 0.0;
  for (int a = 0; a < 3; ++a) {
    m[a] = std::abs(outward[a]) * half_mm[a];
    total += m[a];
  }
  if (distance_mm >= total) return 0.0;
  if (distance_mm <= -total) return 1.0;
  // Unit cube, m1 x + m2 y + m3 z < alpha with m1 + m2 + m3 = 1; a slope too small to be told from
  // zero is raised, which moves the plane by less than the error promised.
  std::sort(m.begin(), m.end());
  m[0] = std::max(m[0], 1e-5 * total);
  m[1] = std::max(m[1], 1e-5 * total);
  const double sum = m[0] + m[1] + m[2];
  for (double& value : m) value /= sum;
  const double plane = std::clamp(0.5 - 0.5 * distance_mm / total, 0.0, 1.0);
  const double alpha = std::min(plane, 1.0 - plane);
  const double m12 = m[0] + m[1];
  double share = 0.0;
  if (alpha < m[0]) {
    share = alpha * alpha * alpha / (6.0 * m[0] * m[1] * m[2]);
  } else if (alpha < m[1]) {
    share = alpha * (alpha - m[0]) / (2.0 * m[1] * m[2]) + m[0] * m[0] / (6.0 * m[1] * m[2]);
  } else if (alpha < std::min(m12, m[2])) {
    share = (alpha * alpha * (3.0 * m12 - alpha) + m[0] * m[0] * (m[0] - 3.0 * alpha) +
             m[1] * m[1] * (m[1] - 3.0 * alpha)) /
            (6.0 * m[0] * m[1] * m[2]);
  } else if (m[2] < m12) {
    share = (alpha * alpha * (3.0 - 2.0 * alpha) + m[0] * m[0] * (m[0] - 3.0 * alpha) +
             m[1] * m[1] * (m[1] - 3.0 * alpha) + m[2] * m[2] * (m[2] - 3.0 * alpha)) /
            (6.0 * m[0] * m[1] * m[2]);
  } else {
    share = (2.0 * alpha - m12) / (2.0 * m[2]);
  }
  return std::clamp(plane < 0.5 ? share : 1.0 - share, 0.0, 1.0);
}

double share_below(const Vec3& normal, const Vec3& half, double offset) {
  std::array<double, 3> m{};
  double whole = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    m[a] = std::max(std::abs(normal[axis]) * 2 * half[axis], 1e-4);
    whole += m[a];
  }
  const double at = offset + 0.5 * whole;
  if (at <= 0) return 0;
  if (at >= whole) return 1;
  const double six = cube(at) - cube(at - m[0]) - cube(at - m[1]) - cube(at - m[2]) +
                     cube(at - m[0] - m[1]) + cube(at - m[0] - m[2]) + cube(at - m[1] - m[2]);
  return std::clamp(six / (6 * m[0] * m[1] * m[2]), 0.0, 1.0);
}

}  // namespace beatlas
