#pragma once
/// The surface around fingers as one field: what the picture draws, what the other fingers feel and
/// what the ventricle loses are read from it.

#include <array>
#include <cstddef>
#include <span>

#include "runtime/base/geometry.h"

namespace beatlas::palpation {

inline constexpr std::size_t kMostFingers = 8;

/// Weight of a dent at a distance r of its middle, x = r / radius: 1 at 0, none from 1 on, twice
/// continuously differentiable; Wendland's (1-x)^4 (4x+1), positive definite in space, so fingers
/// anywhere can be told apart.
[[nodiscard]] double dent_weight(double x) noexcept;

/// Radius [mm] at which the weight's integral over a plane is `contact_area_cm2`: the dent's volume
/// is its depth times S_c of the circulation.
[[nodiscard]] double dent_radius_mm(double contact_area_cm2) noexcept;

/// The same on a surface that is curved or ends: sum of weight times `areas_mm2` of `points_mm`.
/// @throws Error{InvalidInput} if there are no points, or the whole surface is smaller than that.
[[nodiscard]] double dent_radius_on_mm(std::span<const Vec3> points_mm,
                                       std::span<const double> areas_mm2, const Vec3& middle_mm,
                                       double contact_area_cm2);

/// A finger that holds the surface at `depth_mm` under where it would lie.
struct DentSource {
  Vec3 place_mm = Vec3::Zero();
  double depth_mm = 0;
};

/// u(x) = sum A_i w(|x - x_i| / radius), A_i >= 0, such that no finger is inside the surface and
/// every finger with A_i > 0 lies on it.
class DentField {
 public:
  explicit DentField(double radius_mm = 50) noexcept : radius_mm_(radius_mm) {}

  /// At most kMostFingers; more are left out.
  void set(std::span<const DentSource> fingers) noexcept;
  void set_radius_mm(double radius_mm) noexcept { radius_mm_ = radius_mm; }

  /// How far the surface lies under its place, along its inward normal [mm], >= 0.
  [[nodiscard]] double depression_mm(const Vec3& x) const noexcept;
  /// Sum of A_i [mm]: the one dent as large as all together.
  [[nodiscard]] double whole_depth_mm() const noexcept;
  [[nodiscard]] double weight(const Vec3& a, const Vec3& b) const noexcept;
  [[nodiscard]] std::span<const double> amplitudes_mm() const noexcept {
    return std::span(amplitudes_mm_).first(count_);
  }

 private:
  double radius_mm_;
  std::size_t count_ = 0;
  std::array<Vec3, kMostFingers> places_mm_;
  std::array<double, kMostFingers> amplitudes_mm_{};
};

}  // namespace beatlas::palpation
