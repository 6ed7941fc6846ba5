#include "pipeline/field/interpolant.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace beatlas::field {
namespace {

// The four samples around a coordinate on one axis, and what each counts.
struct Taps {
  std::array<std::size_t, 4> at{};
  std::array<double, 4> weight{};
  std::array<double, 4> slope{};
};

Taps taps(double x, int size, std::size_t stride) {
  const double inside = std::clamp(x, 0.0, static_cast<double>(size - 1));
  const int first = std::min(static_cast<int>(inside), std::max(size - 2, 0));
  const double t = inside - first;
  Taps out;
  for (int n = 0; n < 4; ++n) {
    out.at[static_cast<std::size_t>(n)] =
        static_cast<std::size_t>(std::clamp(first + n - 1, 0, size - 1)) * stride;
  }
  out.weight = {((2.0 - t) * t - 1.0) * t * 0.5, ((3.0 * t - 5.0) * t * t + 2.0) * 0.5,
                ((4.0 - 3.0 * t) * t + 1.0) * t * 0.5, (t - 1.0) * t * t * 0.5};
  out.slope = {((4.0 - 3.0 * t) * t - 1.0) * 0.5, (9.0 * t - 10.0) * t * 0.5,
               ((8.0 - 9.0 * t) * t + 1.0) * 0.5, (3.0 * t - 2.0) * t * 0.5};
  return out;
}

}  // namespace

Interpolant::Interpolant(const Grid& grid, std::span<const float> samples)
    : grid_(grid),
      samples_(samples),
      index_from_mm_(grid.mm_from_index.inverse(Eigen::Affine)),
      gradient_from_index_(index_from_mm_.linear().transpose()) {}

double Interpolant::value(const Vec3& mm) const noexcept {
  const Vec3 index = index_from_mm_ * mm;
  const auto row = static_cast<std::size_t>(grid_.size[0]);
  const Taps x = taps(index.x(), grid_.size[0], 1);
  const Taps y = taps(index.y(), grid_.size[1], row);
  const Taps z = taps(index.z(), grid_.size[2], grid_.slice_count());
  double sum = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t j = 0; j < 4; ++j) {
      const float* line = samples_.data() + z.at[k] + y.at[j];
      const double along = x.weight[0] * line[x.at[0]] + x.weight[1] * line[x.at[1]] +
                           x.weight[2] * line[x.at[2]] + x.weight[3] * line[x.at[3]];
      sum += z.weight[k] * y.weight[j] * along;
    }
  }
  return sum;
}

Interpolant::Sample Interpolant::sample(const Vec3& mm) const noexcept {
  const Vec3 index = index_from_mm_ * mm;
  const auto row = static_cast<std::size_t>(grid_.size[0]);
  const Taps x = taps(index.x(), grid_.size[0], 1);
  const Taps y = taps(index.y(), grid_.size[1], row);
  const Taps z = taps(index.z(), grid_.size[2], grid_.slice_count());
  Sample out;
  Vec3 slope = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t j = 0; j < 4; ++j) {
      const float* line = samples_.data() + z.at[k] + y.at[j];
      double along = 0;
      double steep = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        const double v = line[x.at[i]];
        along += x.weight[i] * v;
        steep += x.slope[i] * v;
      }
      out.value += z.weight[k] * y.weight[j] * along;
      slope.x() += z.weight[k] * y.weight[j] * steep;
      slope.y() += z.weight[k] * y.slope[j] * along;
      slope.z() += z.slope[k] * y.weight[j] * along;
    }
  }
  out.gradient = gradient_from_index_ * slope;
  return out;
}

Vec3 Interpolant::project_to_zero(const Vec3& mm, double max_step_mm) const noexcept {
  constexpr int kSteps = 12;
  constexpr double kDoneMm = 1e-5;
  Vec3 x = mm;
  for (int n = 0; n < kSteps; ++n) {
    const Sample here = sample(x);
    const double steep2 = here.gradient.squaredNorm();
    if (steep2 < 1e-12) break;
    Vec3 step = -here.value / steep2 * here.gradient;
    const double length = step.norm();
    if (length > max_step_mm) step *= max_step_mm / length;
    x += step;
    if (length < kDoneMm) break;
  }
  return x;
}

}  // namespace beatlas::field
