#pragma once
/// A cavity as a tool inside it meets it: free where there is blood, contact with the wall around.

#include <memory>

#include "runtime/haptics/contact_field.h"

namespace beatlas::haptics {

/// The field of a cavity with its sign turned: distances are those to the wall, positive in the
/// blood. A valve is closed to the tool, as the cavity's surface is: the field of one cavity does
/// not tell its valve from its wall.
class CavityField final : public ContactField {
 public:
  /// @param cavity negative in the blood
  /// @param depth_mm > 0: how far into the blood directions are known; no tool may have a larger
  /// radius
  /// @throws Error{InvalidInput} if there is no field or no depth.
  CavityField(std::shared_ptr<const ContactField> cavity, double depth_mm);

  [[nodiscard]] FieldSample sample(const Vec3& x, double t) const noexcept override;
  [[nodiscard]] std::unique_ptr<ContactBatch> batch(double width_mm) const override;
  /// Into the blood.
  [[nodiscard]] Vec3 outward(const Vec3& x) const noexcept override { return -cavity_->outward(x); }
  [[nodiscard]] double resolution_mm() const noexcept override { return cavity_->resolution_mm(); }
  [[nodiscard]] double reach_mm() const noexcept override { return depth_mm_; }
  [[nodiscard]] double period_s() const noexcept override { return cavity_->period_s(); }

 private:
  std::shared_ptr<const ContactField> cavity_;
  double depth_mm_;
};

/// Of an atlas's cavity, as deep as its field goes.
/// @throws Error{InvalidInput} if there is no field.
[[nodiscard]] std::shared_ptr<const ContactField> cavity_of(
    std::shared_ptr<const field::FieldQuery> cavity);

}  // namespace beatlas::haptics
