#include "runtime/haptics/contact_field.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::haptics {

void ContactField::sample_all(std::span<const Vec3> points, double t,
                              std::span<FieldSample> out) const noexcept {
  for (std::size_t n = 0; n < points.size(); ++n) out[n] = sample(points[n], t);
}

AtlasField::AtlasField(std::shared_ptr<const field::FieldQuery> field) : field_(std::move(field)) {
  if (!field_) throw_invalid("there is no distance field to touch; open the atlas with it");
}

Vec3 AtlasField::outward(const Vec3& x) const noexcept { return field_->normal(FieldSample{}, x); }

double AtlasField::resolution_mm() const noexcept { return field_->payload().voxel_mm; }

HeldField::HeldField(std::shared_ptr<const ContactField> field, double time_s)
    : field_(std::move(field)), time_s_(time_s) {
  if (!field_) throw_invalid("there is no distance field to hold; open the atlas with it");
  if (!std::isfinite(time_s)) {
    throw_invalid("the time at which the heart is held must be a number of seconds");
  }
}

FieldSample HeldField::sample(const Vec3& x, double /*t*/) const noexcept {
  FieldSample out = field_->sample(x, time_s_);
  out.rate_mm_s = 0;
  return out;
}

void HeldField::sample_all(std::span<const Vec3> points, double /*t*/,
                           std::span<FieldSample> out) const noexcept {
  field_->sample_all(points, time_s_, out);
  for (FieldSample& sample : out.first(points.size())) sample.rate_mm_s = 0;
}

double AtlasField::reach_mm() const noexcept {
  return field_->payload().outer_mm - field_->payload().voxel_mm;
}

}  // namespace beatlas::haptics
