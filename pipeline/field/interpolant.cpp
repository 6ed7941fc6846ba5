#include "pipeline/field/interpolant.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "pipeline/core/cubic_convolution.h"

namespace beatlas::field {
namespace {

using Two = double __attribute__((vector_size(16)));
using TwoFloats = float __attribute__((vector_size(8)));

// Four numbers side by side.
struct Four {
  Two low{};
  Two high{};

  void add(double weight, const Four& of) {
    low += weight * of.low;
    high += weight * of.high;
  }
  [[nodiscard]] double dot(const Four& other) const {
    const Two sum = low * other.low + high * other.high;
    return sum[0] + sum[1];
  }
};
using Weights = std::array<double, 4>;

Four side_by_side(const Weights& w) { return {Two{w[0], w[1]}, Two{w[2], w[3]}}; }

// The four samples around a coordinate on one axis; their numbers rise one by one but at the
// border, whose samples go on beyond it.
struct Taps {
  int first = 0;
  double t = 0;
  bool in_a_row = false;
  std::array<std::size_t, 4> at{};

  Taps(double x, int size, std::size_t stride) {
    // A coordinate that is no number, of a surface that could not be carried, is read at the start.
    const double inside = x > 0 ? std::min(x, static_cast<double>(size - 1)) : 0.0;
    const int left = std::min(static_cast<int>(inside), std::max(size - 2, 0));
    t = inside - left;
    first = left - 1;
    in_a_row = first >= 0 && first + 4 <= size;
    for (int n = 0; n < 4; ++n) {
      at[static_cast<std::size_t>(n)] =
          static_cast<std::size_t>(std::clamp(first + n, 0, size - 1)) * stride;
    }
  }
  [[nodiscard]] Weights weight() const { return cubic_weights(t); }
  [[nodiscard]] Weights slope() const { return cubic_slopes(t); }
};

// Four samples along x.
Four row_of(const float* line, const Taps& x) {
  if (x.in_a_row) {
    TwoFloats low;
    TwoFloats high;
    std::memcpy(&low, line + x.first, sizeof low);
    std::memcpy(&high, line + x.first + 2, sizeof high);
    return {__builtin_convertvector(low, Two), __builtin_convertvector(high, Two)};
  }
  return {Two{line[x.at[0]], line[x.at[1]]}, Two{line[x.at[2]], line[x.at[3]]}};
}

}  // namespace

Interpolant::Interpolant(const Grid& grid, std::span<const float> samples)
    : grid_(grid),
      samples_(samples),
      index_from_mm_(grid.mm_from_index.inverse(Eigen::Affine)),
      gradient_from_index_(index_from_mm_.linear().transpose()) {}

double Interpolant::value(const Vec3& mm) const noexcept {
  const Vec3 index = index_from_mm_ * mm;
  const Taps x(index.x(), grid_.size[0], 1);
  const Taps y(index.y(), grid_.size[1], static_cast<std::size_t>(grid_.size[0]));
  const Taps z(index.z(), grid_.size[2], grid_.slice_count());
  const Weights along_y = y.weight();
  const Weights along_z = z.weight();
  Four rows{};  // of four columns along x what y and z make of them
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t j = 0; j < 4; ++j) {
      rows.add((along_z[k] * along_y[j]), row_of(samples_.data() + z.at[k] + y.at[j], x));
    }
  }
  return rows.dot(side_by_side(x.weight()));
}

Interpolant::Sample Interpolant::sample(const Vec3& mm) const noexcept {
  const Vec3 index = index_from_mm_ * mm;
  const Taps x(index.x(), grid_.size[0], 1);
  const Taps y(index.y(), grid_.size[1], static_cast<std::size_t>(grid_.size[0]));
  const Taps z(index.z(), grid_.size[2], grid_.slice_count());
  const Weights along_y = y.weight();
  const Weights along_z = z.weight();
  const Weights steep_y = y.slope();
  const Weights steep_z = z.slope();
  Four rows{};
  Four rows_y{};
  Four rows_z{};
  for (std::size_t k = 0; k < 4; ++k) {
    Four plane{};
    Four plane_y{};
    for (std::size_t j = 0; j < 4; ++j) {
      const Four row = row_of(samples_.data() + z.at[k] + y.at[j], x);
      plane.add(along_y[j], row);
      plane_y.add(steep_y[j], row);
    }
    rows.add(along_z[k], plane);
    rows_y.add(along_z[k], plane_y);
    rows_z.add(steep_z[k], plane);
  }
  const Four along_x = side_by_side(x.weight());
  const Vec3 slope(rows.dot(side_by_side(x.slope())), rows_y.dot(along_x), rows_z.dot(along_x));
  return {rows.dot(along_x), gradient_from_index_ * slope};
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
