#include "runtime/haptics/two_step.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::haptics {

Vec3 contact_force_n(double stiffness_n_per_m, double distance_mm, const Vec3& normal) noexcept {
  return stiffness_n_per_m * std::max(0.0, -distance_mm) * 1e-3 * normal;
}

TwoStepModel::TwoStepModel(std::shared_ptr<const field::FieldQuery> field,
                           const TwoStepOptions& options)
    : field_(std::move(field)), options_(options) {
  if (!field_) throw_invalid("there is no distance field to touch; open the atlas with it");
  if (!(options_.stiffness_n_per_m >= 1 && options_.stiffness_n_per_m <= 5000)) {
    throw_invalid("the stiffness must be from 1 to 5000 N/m");
  }
  if (options_.held_time_s && !std::isfinite(*options_.held_time_s)) {
    throw_invalid("the time at which the heart is held must be a number of seconds");
  }
}

Contact TwoStepModel::at(const Vec3& x, double t) const noexcept {
  const field::FieldSample sample = field_->sample(x, t);
  Contact contact;
  contact.distance_mm = sample.distance_mm;
  contact.depth_mm = std::max(0.0, -sample.distance_mm);
  contact.touching = contact.depth_mm > 0;
  const bool too_deep = contact.touching && !sample.in_band;
  contact.normal = too_deep && has_direction_ ? direction_ : field_->normal(sample, x);
  contact.surface_velocity_mm_s = field::FieldQuery::normal_velocity_mm_s(sample);
  contact.force_n =
      contact_force_n(options_.stiffness_n_per_m, contact.distance_mm, contact.normal);
  return contact;
}

Contact TwoStepModel::between_frames(const Vec3& x, double t) const noexcept {
  const double frame_s = field_->rr_interval_s() / field_->phases();
  const double s = t / frame_s;
  const double frame = std::floor(s);
  const double share = s - frame;
  const Contact a = at(x, frame * frame_s);
  const Contact b = at(x, (frame + 1) * frame_s);
  Contact contact;
  contact.force_n = (1 - share) * a.force_n + share * b.force_n;
  contact.distance_mm = (1 - share) * a.distance_mm + share * b.distance_mm;
  // The force of the published mode is not a function of one distance: what is felt is the depth.
  contact.depth_mm = 1e3 * contact.force_n.norm() / options_.stiffness_n_per_m;
  contact.touching = contact.depth_mm > 0;
  const Vec3 mixed =
      contact.touching ? contact.force_n : Vec3((1 - share) * a.normal + share * b.normal);
  contact.normal = mixed.norm() > 0 ? mixed.normalized() : a.normal;
  contact.surface_velocity_mm_s = (a.distance_mm - b.distance_mm) / frame_s;
  return contact;
}

Contact TwoStepModel::evaluate(const Vec3& x, double t) noexcept {
  const bool held = options_.held_time_s.has_value();
  const double time = held ? *options_.held_time_s : t;
  Contact contact =
      options_.time_mode == TimeMode::Published ? between_frames(x, time) : at(x, time);
  if (held) contact.surface_velocity_mm_s = 0;
  contact.proxy_mm = x + contact.depth_mm * contact.normal;
  has_direction_ = contact.touching && !contact.normal.isZero();
  if (has_direction_) direction_ = contact.normal;
  return contact;
}

Contact TwoStepModel::evaluate(const ServoState& state, const Moment& moment) noexcept {
  Contact contact = evaluate(state.position_mm, moment.field_time_s);
  contact.surface_velocity_mm_s *= moment.speed;
  return contact;
}

ModelMemory TwoStepModel::memory() const noexcept {
  return {direction_.x(), direction_.y(), direction_.z(), has_direction_ ? 1.0 : 0.0};
}

void TwoStepModel::restore(const ModelMemory& memory) noexcept {
  direction_ = Vec3(memory[0], memory[1], memory[2]);
  has_direction_ = memory[3] != 0;
}

}  // namespace beatlas::haptics
