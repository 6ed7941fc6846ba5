#pragma once
#include "runtime/base/geometry.h"

namespace beatlas::haptics {

inline constexpr double kSoftestNPerM = 1;
inline constexpr double kStiffestNPerM = 5000;

/// A stiffness that differs from place to place. Continuous in both arguments, or the force jumps.
class StiffnessMap {
 public:
  StiffnessMap() = default;
  StiffnessMap(const StiffnessMap&) = delete;
  StiffnessMap& operator=(const StiffnessMap&) = delete;
  virtual ~StiffnessMap() = default;

  /// @param surface_mm a point of the surface, workspace; t [s] of the field.
  /// @return [N/m]; a model keeps it within kSoftestNPerM .. kStiffestNPerM.
  [[nodiscard]] virtual double n_per_m(const Vec3& surface_mm, double t) const noexcept = 0;
};

}  // namespace beatlas::haptics
