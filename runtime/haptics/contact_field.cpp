#include "runtime/haptics/contact_field.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/field/shell_query.h"

namespace beatlas::haptics {
namespace {

class OneByOne final : public ContactBatch {
 public:
  explicit OneByOne(const ContactField& field) : field_(field) {}
  void sample(std::span<const Vec3> points, double t,
              std::span<FieldSample> out) noexcept override {
    for (std::size_t n = 0; n < points.size(); ++n) out[n] = field_.sample(points[n], t);
  }

 private:
  const ContactField& field_;
};

class AtlasBatch final : public ContactBatch {
 public:
  AtlasBatch(std::shared_ptr<const field::FieldQuery> field, std::size_t most_samples)
      : shells_(std::move(field), most_samples) {}
  void sample(std::span<const Vec3> points, double t,
              std::span<FieldSample> out) noexcept override {
    shells_.sample(points, t, out);
  }

 private:
  field::ShellQuery shells_;
};

class HeldBatch final : public ContactBatch {
 public:
  HeldBatch(std::unique_ptr<ContactBatch> batch, double time_s)
      : batch_(std::move(batch)), time_s_(time_s) {}
  void sample(std::span<const Vec3> points, double /*t*/,
              std::span<FieldSample> out) noexcept override {
    batch_->sample(points, time_s_, out);
    for (FieldSample& sample : out.first(points.size())) sample.rate_mm_s = 0;
  }

 private:
  std::unique_ptr<ContactBatch> batch_;
  double time_s_;
};

}  // namespace

std::unique_ptr<ContactBatch> ContactField::batch(double /*width_mm*/) const {
  return std::make_unique<OneByOne>(*this);
}

AtlasField::AtlasField(std::shared_ptr<const field::FieldQuery> field) : field_(std::move(field)) {
  if (!field_) throw_invalid("there is no distance field to touch; open the atlas with it");
}

std::unique_ptr<ContactBatch> AtlasField::batch(double width_mm) const {
  return std::make_unique<AtlasBatch>(
      field_, field::ShellQuery::samples_for(width_mm, field_->payload().voxel_mm));
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

std::unique_ptr<ContactBatch> HeldField::batch(double width_mm) const {
  return std::make_unique<HeldBatch>(field_->batch(width_mm), time_s_);
}

double AtlasField::reach_mm() const noexcept {
  return field_->payload().outer_mm - field_->payload().voxel_mm;
}

double AtlasField::depth_mm() const noexcept {
  return field_->payload().inner_mm - field_->payload().voxel_mm;
}

}  // namespace beatlas::haptics
