#pragma once
/// A cavity as a tool inside it meets it: free where there is blood, contact with the wall around.

#include <memory>
#include <vector>

#include "runtime/haptics/contact_field.h"
#include "runtime/haptics/tube_field.h"

namespace beatlas::haptics {

/// Fields of cavities with their sign turned: distances are those to the wall, positive in the
/// blood. Several that overlap (a ventricle, the way through its valve, an atrium) are one: of them
/// all the deepest counts, which is never more than the way to the wall. Cavities that merely touch
/// stay apart.
class CavityField final : public ContactField {
 public:
  /// @param cavities negative in the blood, of one cycle; the first is where a tool that lies
  /// nowhere is led to
  /// @param depth_mm > 0: how far into the blood directions are known; no tool may have a larger
  /// radius
  /// @throws Error{InvalidInput} if there is none, one is null, or there is no depth.
  CavityField(std::vector<std::shared_ptr<const ContactField>> cavities, double depth_mm);

  [[nodiscard]] FieldSample sample(const Vec3& x, double t) const noexcept override;
  [[nodiscard]] std::unique_ptr<ContactBatch> batch(double width_mm) const override;
  /// Into the blood.
  [[nodiscard]] Vec3 outward(const Vec3& x) const noexcept override {
    return -cavities_.front()->outward(x);
  }
  [[nodiscard]] double resolution_mm() const noexcept override { return resolution_mm_; }
  [[nodiscard]] double reach_mm() const noexcept override { return depth_mm_; }
  [[nodiscard]] double period_s() const noexcept override { return cavities_.front()->period_s(); }

 private:
  std::vector<std::shared_ptr<const ContactField>> cavities_;
  double depth_mm_;
  double resolution_mm_;
};

/// Of an atlas's cavity, as deep as its field goes.
/// @param valve the way out of it; null: its valve is closed to the tool
/// @throws Error{InvalidInput} if there is no field.
[[nodiscard]] std::shared_ptr<const ContactField> cavity_of(
    std::shared_ptr<const field::FieldQuery> cavity,
    const std::shared_ptr<const TubeField>& valve = nullptr);

}  // namespace beatlas::haptics
