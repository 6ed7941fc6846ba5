#pragma once
/// A half space z < 0 whose surface moves along z, known everywhere: what patches are pressed into.

#include "runtime/haptics/contact_field.h"

namespace beatlas::palpation::test {

class PlaneField : public haptics::ContactField {
 public:
  explicit PlaneField(double period_s) : period_s_(period_s) {}
  [[nodiscard]] Vec3 outward(const Vec3& /*x*/) const noexcept override { return Vec3::UnitZ(); }
  [[nodiscard]] double resolution_mm() const noexcept override { return 1; }
  [[nodiscard]] double reach_mm() const noexcept override { return 100; }
  [[nodiscard]] double period_s() const noexcept override { return period_s_; }

 protected:
  /// @param height_mm of the surface  @param speed_mm_s at which it rises
  [[nodiscard]] static haptics::FieldSample above(const Vec3& x, double height_mm,
                                                  double speed_mm_s) noexcept {
    haptics::FieldSample out;
    out.distance_mm = x.z() - height_mm;
    out.gradient = Vec3::UnitZ();
    out.rate_mm_s = -speed_mm_s;
    out.in_band = true;
    return out;
  }

 private:
  double period_s_;
};

}  // namespace beatlas::palpation::test
