#include "pipeline/phantom/flow_void.h"

#include <algorithm>
#include <cmath>

#include "pipeline/phantom/motion.h"

namespace beatlas::phantom {
namespace {

/// ds/dt of a cycle of 1 s.
double loss_rate(double cycles) {
  constexpr double kHalfStep = 1e-4;
  return (volume_loss(cycles + kHalfStep, 1.0) - volume_loss(cycles - kHalfStep, 1.0)) /
         (2.0 * kHalfStep);
}

double highest_rate() {
  constexpr int kSteps = 2000;
  double out = 0.0;
  for (int n = 0; n < kSteps; ++n) out = std::max(out, loss_rate(static_cast<double>(n) / kSteps));
  return out;
}

/// 0 below -1 mm, 1 above 1 mm.
double smooth_step(double mm) {
  const double u = std::clamp(0.5 + 0.5 * mm, 0.0, 1.0);
  return u * u * (3.0 - 2.0 * u);
}

}  // namespace

JetCone jet_cone(const HeartShape& shape, double scale) {
  constexpr double kBelow = 25.0;
  constexpr double kAbove = 35.0;
  constexpr double kRadiusAtValve = 10.0;
  constexpr double kX = -4.0;  // of the outlet's axis
  constexpr double kY = 20.0;
  JetCone out;
  out.tip = Vec3(scale * kX, scale * kY, shape.lv_base_z_mm - scale * kBelow);
  out.length_mm = scale * (kBelow + kAbove);
  out.slope = kRadiusAtValve / kBelow;
  return out;
}

double jet_weight(const JetCone& cone, const Vec3& heart_mm) {
  const Vec3 x = heart_mm - cone.tip;
  if (x.z() <= -1.0 || x.z() >= cone.length_mm + 1.0) return 0.0;
  const double across = std::hypot(x.x(), x.y());
  const double inward = (cone.slope * x.z() - across) / std::hypot(1.0, cone.slope);
  return smooth_step(inward) * smooth_step(cone.length_mm - x.z());
}

double ejection_rate(double t_s, double rr_interval_s) {
  static const double kHighest = highest_rate();
  return std::clamp(loss_rate(t_s / rr_interval_s) / kHighest, 0.0, 1.0);
}

}  // namespace beatlas::phantom
