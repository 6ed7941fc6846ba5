#pragma once
/// The body as a contact model sees it: a signed distance that moves. An atlas is one; a closed
/// form, for tests and for whoever embeds the models, is another.

#include <memory>
#include <span>

#include "runtime/field/field_query.h"

namespace beatlas::haptics {

using field::FieldSample;

/// Asks one field for many points at one time. Has scratch memory, so it serves one thread.
class ContactBatch {
 public:
  ContactBatch() = default;
  ContactBatch(const ContactBatch&) = delete;
  ContactBatch& operator=(const ContactBatch&) = delete;
  virtual ~ContactBatch() = default;

  /// The answers of ContactField::sample, bit for bit; allocates nothing. `out` is as long as
  /// `points`.
  virtual void sample(std::span<const Vec3> points, double t,
                      std::span<FieldSample> out) noexcept = 0;
};

/// Immutable and thread-safe. Frame: workspace [mm]; time [s] of the field, any.
class ContactField {
 public:
  ContactField() = default;
  ContactField(const ContactField&) = delete;
  ContactField& operator=(const ContactField&) = delete;
  virtual ~ContactField() = default;

  /// Distance, its gradient and its rate. Where it is clamped the gradient is 0, and the distance
  /// is nowhere larger than the true one by more than a fifth.
  [[nodiscard]] virtual FieldSample sample(const Vec3& x, double t) const noexcept = 0;
  /// For points at one time that lie within a cube of `width_mm`; others are answered as well, more
  /// slowly. Here one by one; a source that can do better says so. The field must outlive
  /// it.
  [[nodiscard]] virtual std::unique_ptr<ContactBatch> batch(double width_mm) const;
  /// Unit direction out of the body where the field has none; zero if there is none at all.
  [[nodiscard]] virtual Vec3 outward(const Vec3& x) const noexcept = 0;
  /// No wall is thinner than 1.5 times this [mm] > 0: the voxel of a sampled field.
  [[nodiscard]] virtual double resolution_mm() const noexcept = 0;
  /// Largest distance outside at which directions are known [mm]; no tool may have a larger radius.
  [[nodiscard]] virtual double reach_mm() const noexcept = 0;
  /// Of one cycle [s] > 0.
  [[nodiscard]] virtual double period_s() const noexcept = 0;
};

/// The field of an atlas.
class AtlasField final : public ContactField {
 public:
  /// @throws Error{InvalidInput} if there is no field.
  explicit AtlasField(std::shared_ptr<const field::FieldQuery> field);

  [[nodiscard]] FieldSample sample(const Vec3& x, double t) const noexcept override {
    return field_->sample(x, t);
  }
  /// By field::ShellQuery.
  [[nodiscard]] std::unique_ptr<ContactBatch> batch(double width_mm) const override;
  [[nodiscard]] Vec3 outward(const Vec3& x) const noexcept override;
  [[nodiscard]] double resolution_mm() const noexcept override;
  [[nodiscard]] double reach_mm() const noexcept override;
  /// Largest distance inside at which directions are known [mm].
  [[nodiscard]] double depth_mm() const noexcept;
  [[nodiscard]] double period_s() const noexcept override { return field_->rr_interval_s(); }

 private:
  std::shared_ptr<const field::FieldQuery> field_;
};

/// Another field, standing still at one time.
class HeldField final : public ContactField {
 public:
  /// @throws Error{InvalidInput} if there is no field or the time is no number.
  HeldField(std::shared_ptr<const ContactField> field, double time_s);

  [[nodiscard]] FieldSample sample(const Vec3& x, double t) const noexcept override;
  [[nodiscard]] std::unique_ptr<ContactBatch> batch(double width_mm) const override;
  [[nodiscard]] Vec3 outward(const Vec3& x) const noexcept override { return field_->outward(x); }
  [[nodiscard]] double resolution_mm() const noexcept override { return field_->resolution_mm(); }
  [[nodiscard]] double reach_mm() const noexcept override { return field_->reach_mm(); }
  [[nodiscard]] double period_s() const noexcept override { return field_->period_s(); }

 private:
  std::shared_ptr<const ContactField> field_;
  double time_s_;
};

}  // namespace beatlas::haptics
