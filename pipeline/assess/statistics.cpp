#include "pipeline/assess/statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace beatlas::assess {

DistanceStatistics pooled_statistics(const std::vector<Weighted>& one,
                                     const std::vector<Weighted>& other) {
  std::vector<Weighted> all;
  for (const std::vector<Weighted>* list : {&one, &other}) {
    double total = 0.0;
    for (const Weighted& each : *list) total += each.weight;
    for (const Weighted& each : *list) all.push_back({each.value, each.weight / total});
  }
  DistanceStatistics out;
  double total = 0.0;
  for (const Weighted& each : all) {
    out.mean += each.weight * std::abs(each.value);
    out.rms += each.weight * each.value * each.value;
    out.bias += each.weight * each.value;
    out.maximum = std::max(out.maximum, std::abs(each.value));
    total += each.weight;
  }
  if (all.empty() || !(total > 0.0)) return {};
  out.mean /= total;
  out.rms = std::sqrt(out.rms / total);
  out.bias /= total;
  std::sort(all.begin(), all.end(), [](const Weighted& a, const Weighted& b) {
    const double x = std::abs(a.value);
    const double y = std::abs(b.value);
    return x != y ? x < y : a.weight < b.weight;
  });
  double below = 0.0;
  out.p95 = out.maximum;
  for (const Weighted& each : all) {
    below += each.weight;
    if (below >= 0.95 * total * (1.0 - 1e-12)) {
      out.p95 = std::abs(each.value);
      break;
    }
  }
  return out;
}

double angle_deg(const Vec3& a, const Vec3& b) {
  if (!(a.norm() * b.norm() > 0.0)) return 180.0;
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
}

}  // namespace beatlas::assess
