#include "pipeline/phantom/coil_bias.h"

#include <algorithm>
#include <cmath>

#include "pipeline/phantom/noise.h"

namespace beatlas::phantom {

CoilBias::CoilBias(const PhantomSpec& spec)
    : share_(spec.scanner.bias_share),
      origin_(spec.anatomy.origin_lps_mm),
      length_mm_(80.0 * std::max(1.0, spec.anatomy.scale)) {
  const auto seed = static_cast<std::uint32_t>(spec.scanner.bias_seed);
  const auto tilt = normal_pair(0, 0, seed, Draw::Bias);
  const auto turn = normal_pair(1, 0, seed, Draw::Bias);
  constexpr double kTilt = 0.2;
  constexpr double kMost = 1.6;  // sigmas
  const auto cut = [&](double value) { return std::clamp(value, -kMost, kMost); };
  toward_ = Vec3(kTilt * cut(tilt[0]), -1.0, kTilt * cut(tilt[1])).normalized();
  const Vec3 first = toward_.cross(Vec3(turn[0], 0.0, turn[1]) + Vec3(1e-3, 0.0, 0.0)).normalized();
  across_ = first;
  other_ = toward_.cross(first);
}

double CoilBias::at(const Vec3& lps) const {
  const Vec3 u = (lps - origin_) / length_mm_;
  return 1.0 + share_ * std::tanh(u.dot(toward_) + 0.3 * u.dot(across_) * u.dot(other_));
}

}  // namespace beatlas::phantom
