#pragma once
/// Bodies whose distance, gradient and rate are written down, for the contact models' tests, and
/// the same ones as an atlas would hold them.

#include <functional>
#include <memory>
#include <utility>

#include "runtime/haptics/contact_field.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas::testing {

/// A body of a closed form; `resolution_mm` as the thickness of its walls allows.
class FormField final : public haptics::ContactField {
 public:
  using Form = std::function<field::FieldSample(const Vec3&, double)>;

  FormField(double resolution_mm, double period_s, Form form)
      : resolution_mm_(resolution_mm), period_s_(period_s), form_(std::move(form)) {}

  [[nodiscard]] field::FieldSample sample(const Vec3& x, double t) const noexcept override {
    return form_(x, t);
  }
  [[nodiscard]] Vec3 outward(const Vec3& x) const noexcept override {
    return x.norm() > 0 ? Vec3(x.normalized()) : Vec3::Zero();
  }
  [[nodiscard]] double resolution_mm() const noexcept override { return resolution_mm_; }
  [[nodiscard]] double reach_mm() const noexcept override { return 100; }
  [[nodiscard]] double period_s() const noexcept override { return period_s_; }

 private:
  double resolution_mm_;
  double period_s_;
  Form form_;
};

inline field::FieldSample made_sample(double distance_mm, const Vec3& gradient,
                                      double rate_mm_s = 0) {
  field::FieldSample out;
  out.distance_mm = distance_mm;
  out.gradient = gradient;
  out.rate_mm_s = rate_mm_s;
  out.in_band = true;
  return out;
}

/// `phi` sampled and prefiltered as in a package.
inline std::shared_ptr<const haptics::ContactField> packed(const LatticeSpec& spec,
                                                           const Distance& phi) {
  return std::make_shared<const haptics::AtlasField>(
      std::make_shared<const field::FieldQuery>(dense_payload(spec, phi), spec.rr_interval_s));
}

}  // namespace beatlas::testing
