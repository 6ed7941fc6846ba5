#include "pipeline/phantom/share.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "pipeline/core/box_share.h"

namespace beatlas::phantom {
namespace {

/// The normal distribution integrated `times` times over again, from minus infinity to x.
double normal_integral(double x, int times) {
  const double below = 0.5 * std::erfc(-x * std::numbers::sqrt2 / 2.0);
  if (times == 0) return below;
  const double density = std::exp(-0.5 * x * x) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
  switch (times) {
    case 1:
      return x * below + density;
    case 2:
      return 0.5 * ((x * x + 1.0) * below + x * density);
    default:
      return ((x * x + 3.0) * x * below + (x * x + 2.0) * density) / 6.0;
  }
}

}  // namespace

double blurred_box_share(const Vec3& half_mm, const Vec3& sigma_mm, double distance_mm,
                         const Vec3& outward) {
  double variance = outward.cwiseProduct(sigma_mm).squaredNorm();
  if (variance <= 0.0) return box_share(half_mm, distance_mm, outward);
  std::array<double, 3> edges{};
  for (int a = 0; a < 3; ++a) edges[a] = std::abs(outward[a]) * half_mm[a];
  const double reach = edges[0] + edges[1] + edges[2] + kBlurSigmas * std::sqrt(variance);
  if (distance_mm >= reach) return 0.0;
  if (distance_mm <= -reach) return 1.0;
  std::sort(edges.begin(), edges.end());
  int first = 0;  // of the edges that count as such
  constexpr double kWide = 0.5;
  while (first < 3 && edges[first] * edges[first] < kWide * kWide * variance) {
    variance += edges[first] * edges[first] / 3.0;
    ++first;
  }
  const double sigma = std::sqrt(variance);
  const int count = 3 - first;
  double sum = 0.0;
  double scale = 1.0;
  for (int a = first; a < 3; ++a) scale *= sigma / (2.0 * edges[a]);
  for (int signs = 0; signs < 1 << count; ++signs) {
    double x = -distance_mm;
    double sign = 1.0;
    for (int a = 0; a < count; ++a) {
      const bool plus = (signs >> a & 1) == 0;
      x += plus ? edges[first + a] : -edges[first + a];
      if (!plus) sign = -sign;
    }
    sum += sign * normal_integral(x / sigma, count);
  }
  return std::clamp(scale * sum, 0.0, 1.0);
}

}  // namespace beatlas::phantom
