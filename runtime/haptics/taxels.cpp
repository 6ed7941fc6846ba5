#include "runtime/haptics/taxels.h"

#include <algorithm>
#include <cmath>

#include "runtime/base/error.h"
#include "runtime/haptics/servo.h"

namespace beatlas::haptics {
namespace {

constexpr int kParts = 6;  ///< of a taxel's side, for its mean

/// Weights of the middles of a taxel's parts, between its two corners.
constexpr std::array<double, kParts> kPartWeights = [] {
  std::array<double, kParts> out{};
  for (std::size_t n = 0; n < out.size(); ++n) out[n] = (static_cast<double>(n) + 0.5) / kParts;
  return out;
}();

}  // namespace

Vec3 across(const Vec3& n, const Vec3& wished) noexcept {
  const Vec3 part = wished - wished.dot(n) * n;
  if (part.norm() > 1e-3 * wished.norm()) return part.normalized();
  return n.unitOrthogonal();
}

BallContact ball_contact(const Published& seen, const Vec3& right) noexcept {
  BallContact out;
  out.right = right;
  if (!seen.touching) return out;
  out.proxy_mm = Vec3(seen.proxy_mm.data());
  out.normal = Vec3(seen.normal.data());
  out.force_n = Vec3(seen.force_n.data());
  out.depth_mm = (out.proxy_mm - Vec3(seen.position_mm.data())).dot(out.normal);
  return out;
}

Taxels::Taxels(std::shared_ptr<const ContactField> field, const TaxelOptions& options)
    : field_(std::move(field)), options_(options) {
  if (!field_) throw_invalid("taxels need a field");
  if (!(options_.radius_mm >= TaxelOptions::kLeastRadiusMm &&
        options_.radius_mm <= TaxelOptions::kMostRadiusMm)) {
    throw_invalid("the radius of a ball with taxels must be from 0.5 to 50 mm");
  }
  if (options_.pitch_mm == 0) options_.pitch_mm = 2 * options_.radius_mm / TaxelMap::kSide;
  if (!(options_.pitch_mm >= TaxelOptions::kLeastPitchMm &&
        options_.pitch_mm <= TaxelOptions::kMostPitchMm)) {
    throw_invalid("the pitch of taxels must be from 0.05 to 20 mm");
  }
  batch_ = field_->batch(std::sqrt(2.0) * TaxelMap::kSide * options_.pitch_mm);
}

TaxelMap Taxels::under(const BallContact& contact, double t) noexcept {
  constexpr int kSide = TaxelMap::kSide;
  TaxelMap out;
  out.pitch_mm = options_.pitch_mm;
  const double normal_n = contact.force_n.dot(contact.normal);
  if (!(contact.depth_mm > 0 && normal_n > 0 && std::isfinite(normal_n) &&
        contact.proxy_mm.allFinite())) {
    return out;
  }
  const Vec3 n = contact.normal.normalized();
  out.right = across(n, contact.right);
  out.up = n.cross(out.right);
  out.centre_mm = contact.proxy_mm - options_.radius_mm * n;
  for (int row = 0, at = 0; row < kNodes; ++row) {
    for (int column = 0; column < kNodes; ++column, ++at) {
      points_mm_[static_cast<std::size_t>(at)] =
          out.centre_mm +
          options_.pitch_mm * ((column - kSide / 2) * out.right + (row - kSide / 2) * out.up);
    }
  }
  batch_->sample(points_mm_, t, samples_);
  Nodes stiffness;
  if (options_.map) {
    for (std::size_t at = 0; at < stiffness.size(); ++at) {
      // Of the surface's point over the node; where there is no direction, of the node.
      const FieldSample& sample = samples_[at];
      stiffness[at] =
          options_.map->n_per_m(points_mm_[at] - sample.distance_mm * sample.gradient, t);
    }
  }

  const double part_mm = options_.pitch_mm / kParts;
  double whole = 0;  // sum of what is proportional to pressure
  Touched touched;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const double sum = sum_of_parts(row, column, contact.depth_mm, stiffness, touched);
      out.pressure_kpa[static_cast<std::size_t>(row * kSide + column)] = static_cast<float>(sum);
      whole += sum;
    }
  }
  if (!(whole > 0)) {
    out.pressure_kpa.fill(0);
    return out;
  }
  const double per_part = TaxelMap::kKpaPerNMm2 * normal_n / (whole * part_mm * part_mm);
  for (float& pressure : out.pressure_kpa) {
    pressure = static_cast<float>(pressure * per_part / (kParts * kParts));
  }
  out.peak_kpa = touched.peak * per_part;
  out.area_mm2 = touched.parts * part_mm * part_mm;
  return out;
}

double Taxels::sum_of_parts(int row, int column, double depth_mm, const Nodes& stiffness,
                            Touched& touched) const noexcept {
  constexpr int kSide = TaxelMap::kSide;
  const double radius2 = options_.radius_mm * options_.radius_mm;
  const auto corner = static_cast<std::size_t>(row * kNodes + column);
  const auto between = [&](const auto& value, double x, double y) {
    return (1 - y) * ((1 - x) * value(corner) + x * value(corner + 1)) +
           y * ((1 - x) * value(corner + kNodes) + x * value(corner + kNodes + 1));
  };
  double sum = 0;
  for (const double y : kPartWeights) {
    const double v = (row - kSide / 2 + y) * options_.pitch_mm;
    for (const double x : kPartWeights) {
      const double u = (column - kSide / 2 + x) * options_.pitch_mm;
      const double r2 = u * u + v * v;
      const double body = between([&](std::size_t at) { return samples_[at].distance_mm; }, x, y);
      const double left = depth_mm - r2 / options_.radius_mm - 2 * body;
      if (left <= 0 || r2 > radius2) continue;
      double pressure = std::sqrt(left);
      if (options_.map) {
        pressure *= between([&](std::size_t at) { return stiffness[at]; }, x, y);
      }
      sum += pressure;
      touched.peak = std::max(touched.peak, pressure);
      ++touched.parts;
    }
  }
  return sum;
}

}  // namespace beatlas::haptics
