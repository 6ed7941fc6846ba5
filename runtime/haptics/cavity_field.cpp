#include "runtime/haptics/cavity_field.h"

#include <utility>

#include "runtime/base/error.h"

namespace beatlas::haptics {
namespace {

void turn(FieldSample& sample) noexcept {
  sample.distance_mm = -sample.distance_mm;
  sample.gradient = -sample.gradient;
  sample.rate_mm_s = -sample.rate_mm_s;
}

class CavityBatch final : public ContactBatch {
 public:
  explicit CavityBatch(std::unique_ptr<ContactBatch> batch) : batch_(std::move(batch)) {}
  void sample(std::span<const Vec3> points, double t,
              std::span<FieldSample> out) noexcept override {
    batch_->sample(points, t, out);
    for (FieldSample& sample : out.first(points.size())) turn(sample);
  }

 private:
  std::unique_ptr<ContactBatch> batch_;
};

}  // namespace

CavityField::CavityField(std::shared_ptr<const ContactField> cavity, double depth_mm)
    : cavity_(std::move(cavity)), depth_mm_(depth_mm) {
  if (!cavity_) throw_invalid("there is no cavity to be in; open the atlas with its field");
  if (!(depth_mm > 0)) throw_invalid("a cavity must be known to some depth");
}

FieldSample CavityField::sample(const Vec3& x, double t) const noexcept {
  FieldSample out = cavity_->sample(x, t);
  turn(out);
  return out;
}

std::unique_ptr<ContactBatch> CavityField::batch(double width_mm) const {
  return std::make_unique<CavityBatch>(cavity_->batch(width_mm));
}

std::shared_ptr<const ContactField> cavity_of(std::shared_ptr<const field::FieldQuery> cavity) {
  auto body = std::make_shared<const AtlasField>(std::move(cavity));
  const double depth_mm = body->depth_mm();
  return std::make_shared<const CavityField>(std::move(body), depth_mm);
}

}  // namespace beatlas::haptics
