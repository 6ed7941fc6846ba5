#include "runtime/palpation/dent.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/base/error.h"

namespace beatlas::palpation {
namespace {

constexpr double kMm2PerCm2 = 100;
constexpr int kMostSweeps = 200;
constexpr int kHalvings = 60;

}  // namespace

double dent_weight(double x) noexcept {
  if (!(x < 1)) return 0;
  const double square = (1 - x) * (1 - x);
  return square * square * (4 * x + 1);
}

double dent_radius_mm(double contact_area_cm2) noexcept {
  // The integral over a plane is pi radius^2 / 7.
  return std::sqrt(7 * kMm2PerCm2 * contact_area_cm2 / std::numbers::pi);
}

double dent_radius_on_mm(std::span<const Vec3> points_mm, std::span<const double> areas_mm2,
                         const Vec3& middle_mm, double contact_area_cm2) {
  if (points_mm.empty() || points_mm.size() != areas_mm2.size()) {
    throw_invalid("a dented surface must have points, each with its area");
  }
  const double target_mm2 = kMm2PerCm2 * contact_area_cm2;
  const auto area_mm2 = [&](double radius_mm) {
    double sum = 0;
    for (std::size_t n = 0; n < points_mm.size(); ++n) {
      sum += areas_mm2[n] * dent_weight((points_mm[n] - middle_mm).norm() / radius_mm);
    }
    return sum;
  };
  double low = 0;
  double high = dent_radius_mm(contact_area_cm2);
  while (area_mm2(high) < target_mm2) {
    low = high;
    high *= 2;
    if (high > 1e6) {
      throw_invalid("the surface is smaller than the area that one finger's dent takes");
    }
  }
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (area_mm2(middle) < target_mm2 ? low : high) = middle;
  }
  return high;
}

double DentField::weight(const Vec3& a, const Vec3& b) const noexcept {
  return dent_weight((a - b).norm() / radius_mm_);
}

void DentField::set(std::span<const DentSource> fingers) noexcept {
  const std::size_t count = std::min(fingers.size(), kMostFingers);
  // From where the fingers were: from tick to tick they hardly move.
  if (count != count_) amplitudes_mm_ = {};
  count_ = count;
  std::array<std::array<double, kMostFingers>, kMostFingers> weights{};
  for (std::size_t i = 0; i < count_; ++i) {
    places_mm_[i] = fingers[i].place_mm;
    for (std::size_t j = 0; j < i; ++j) {
      weights[i][j] = weights[j][i] = weight(places_mm_[i], places_mm_[j]);
    }
  }
  // Projected Gauss-Seidel: the weights are positive definite, so it comes to the one solution.
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double moved = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      double others = 0;
      for (std::size_t j = 0; j < count_; ++j) others += weights[i][j] * amplitudes_mm_[j];
      const double next = std::max(0.0, fingers[i].depth_mm - others);
      moved = std::max(moved, std::abs(next - amplitudes_mm_[i]));
      amplitudes_mm_[i] = next;
    }
    if (moved < 1e-7) break;  // 0.1 nm
  }
}

double DentField::depression_mm(const Vec3& x) const noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < count_; ++i) sum += amplitudes_mm_[i] * weight(places_mm_[i], x);
  return sum;
}

double DentField::whole_depth_mm() const noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < count_; ++i) sum += amplitudes_mm_[i];
  return sum;
}

}  // namespace beatlas::palpation
