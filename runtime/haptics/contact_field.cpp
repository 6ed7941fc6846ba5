#include "runtime/haptics/contact_field.h"

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

double AtlasField::reach_mm() const noexcept {
  return field_->payload().outer_mm - field_->payload().voxel_mm;
}

}  // namespace beatlas::haptics
