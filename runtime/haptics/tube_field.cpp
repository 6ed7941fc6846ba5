#include "runtime/haptics/tube_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::haptics {

TubeField::TubeField(std::vector<Opening> phases, double period_s, const TubeOptions& options)
    : phases_(std::move(phases)), period_s_(period_s), options_(options) {
  if (phases_.empty()) throw_invalid("a valve's opening has no phase");
  if (!(period_s > 0) || !std::isfinite(period_s)) {
    throw_invalid("the cycle of a valve's opening must be a positive number of seconds");
  }
  if (!(options.inward_mm >= 0) || !(options.outward_mm >= 0)) {
    throw_invalid("a valve's tube must reach 0 mm or more to either side");
  }
  least_radius_mm_ = std::numeric_limits<double>::infinity();
  for (const Opening& each : phases_) {
    const double length = each.normal.norm();
    if (!each.centre_mm.allFinite() || !(std::abs(length - 1) < 1e-6) || !(each.radius_mm > 0)) {
      throw_invalid("a valve's opening needs a centre, a unit normal and a radius in every phase");
    }
    least_radius_mm_ = std::min(least_radius_mm_, each.radius_mm);
  }
}

TubeField::Moving TubeField::moving_at(double t) const noexcept {
  const std::size_t count = phases_.size();
  const double per_s = static_cast<double>(count) / period_s_;
  const double beats = t / period_s_;
  const double s = (beats - std::floor(beats)) * static_cast<double>(count);
  const std::size_t before = std::min(static_cast<std::size_t>(s), count - 1);
  const double u = s - static_cast<double>(before);
  const std::array<double, 4> weight{
      0.5 * (-u + 2 * u * u - u * u * u), 0.5 * (2 - 5 * u * u + 3 * u * u * u),
      0.5 * (u + 4 * u * u - 3 * u * u * u), 0.5 * (-u * u + u * u * u)};
  const std::array<double, 4> slope{
      0.5 * per_s * (-1 + 4 * u - 3 * u * u), 0.5 * per_s * (-10 * u + 9 * u * u),
      0.5 * per_s * (1 + 8 * u - 9 * u * u), 0.5 * per_s * (-2 * u + 3 * u * u)};
  Moving out;
  out.now.normal = Vec3::Zero();
  out.rate.normal = Vec3::Zero();
  for (std::size_t n = 0; n < 4; ++n) {
    const Opening& phase = phases_[(before + count + n - 1) % count];
    out.now.centre_mm += weight[n] * phase.centre_mm;
    out.now.normal += weight[n] * phase.normal;
    out.now.radius_mm += weight[n] * phase.radius_mm;
    out.rate.centre_mm += slope[n] * phase.centre_mm;
    out.rate.normal += slope[n] * phase.normal;
    out.rate.radius_mm += slope[n] * phase.radius_mm;
  }
  const double length = std::max(out.now.normal.norm(), 1e-9);
  out.now.normal /= length;
  const Vec3 turning = out.rate.normal / length;
  out.rate.normal = turning - turning.dot(out.now.normal) * out.now.normal;
  return out;
}

Opening TubeField::at(double t) const noexcept { return moving_at(t).now; }

FieldSample TubeField::sample(const Vec3& x, double t) const noexcept {
  FieldSample out;
  if (!x.allFinite() || !std::isfinite(t)) {
    out.distance_mm = reach_mm();
    return out;
  }
  const Moving moving = moving_at(t);
  const Vec3 from = x - moving.now.centre_mm;
  const double along =
      std::clamp(from.dot(moving.now.normal), -options_.inward_mm, options_.outward_mm);
  const Vec3 off = from - along * moving.now.normal;
  const double length = off.norm();
  out.distance_mm = length - moving.now.radius_mm;
  out.in_band = true;
  if (length > 1e-9) {
    out.gradient = off / length;
    out.rate_mm_s = -out.gradient.dot(moving.rate.centre_mm + along * moving.rate.normal);
  }
  out.rate_mm_s -= moving.rate.radius_mm;
  return out;
}

Vec3 TubeField::outward(const Vec3& x) const noexcept {
  const Opening& opening = phases_.front();
  const Vec3 from = x - opening.centre_mm;
  const Vec3 off = from - from.dot(opening.normal) * opening.normal;
  const double length = off.norm();
  return length > 0 && std::isfinite(length) ? Vec3(off / length) : Vec3::Zero();
}

}  // namespace beatlas::haptics
