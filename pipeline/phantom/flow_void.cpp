#include "pipeline/phantom/flow_void.h"

#include <algorithm>
#include <cmath>

#include "pipeline/phantom/motion.h"

namespace beatlas::phantom {
namespace {

double highest_rate() {
  constexpr int kLossSteps = 2000;
  double out = 0.0;
  for (int n = 0; n < kLossSteps; ++n) {
    out = std::max(out, volume_loss_rate(static_cast<double>(n) / kLossSteps, 1.0));
  }
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
  // Of the outlet's axis in a heart without aorta.
  const Vec3 outlet =
      shape.aorta ? shape.aorta->lumen.centre_mm : Vec3(scale * Vec3(4.0, 22.0, 0.0));
  JetCone out;
  out.tip = Vec3(outlet.x(), outlet.y(), shape.lv_base_z_mm - scale * kBelow);
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
  return std::clamp(volume_loss_rate(t_s / rr_interval_s, 1.0) / kHighest, 0.0, 1.0);
}

}  // namespace beatlas::phantom
