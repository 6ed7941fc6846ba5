#include "runtime/haptics/cavity_field.h"

#include <algorithm>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::haptics {
namespace {

void turn(FieldSample& sample) noexcept {
  sample.distance_mm = -sample.distance_mm;
  sample.gradient = -sample.gradient;
  sample.rate_mm_s = -sample.rate_mm_s;
}

/// Of one cavity.
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

CavityField::CavityField(std::vector<std::shared_ptr<const ContactField>> cavities, double depth_mm)
    : cavities_(std::move(cavities)), depth_mm_(depth_mm) {
  if (cavities_.empty() ||
      std::any_of(cavities_.begin(), cavities_.end(), [](const auto& each) { return !each; })) {
    throw_invalid("there is no cavity to be in; open the atlas with its field");
  }
  if (!(depth_mm > 0)) throw_invalid("a cavity must be known to some depth");
  resolution_mm_ = cavities_.front()->resolution_mm();
  for (const auto& each : cavities_) {
    resolution_mm_ = std::min(resolution_mm_, each->resolution_mm());
  }
}

FieldSample CavityField::sample(const Vec3& x, double t) const noexcept {
  FieldSample out = cavities_.front()->sample(x, t);
  for (std::size_t n = 1; n < cavities_.size(); ++n) {
    const FieldSample other = cavities_[n]->sample(x, t);
    if (other.distance_mm < out.distance_mm) out = other;
  }
  turn(out);
  return out;
}

std::unique_ptr<ContactBatch> CavityField::batch(double width_mm) const {
  if (cavities_.size() > 1) return ContactField::batch(width_mm);
  return std::make_unique<CavityBatch>(cavities_.front()->batch(width_mm));
}

std::shared_ptr<const ContactField> cavity_of(std::shared_ptr<const field::FieldQuery> cavity,
                                              const std::shared_ptr<const TubeField>& valve) {
  auto body = std::make_shared<const AtlasField>(std::move(cavity));
  double depth_mm = body->depth_mm();
  std::vector<std::shared_ptr<const ContactField>> cavities{std::move(body)};
  if (valve) {
    depth_mm = std::min(depth_mm, valve->least_radius_mm());
    cavities.push_back(valve);
  }
  return std::make_shared<const CavityField>(std::move(cavities), depth_mm);
}

}  // namespace beatlas::haptics
