#pragma once
/// Paper A's two-step model on a signed distance field (Nakao et al., MEDINFO 2001).
///
/// Static step: the heart stands still and the user moves. Inside heart data means contact; the
/// passive force is proportional to the distance from the contact point, with one elastic
/// coefficient. Dynamic step: the user stays and the surface moves over the user; the same law.
/// On a distance field the contact point ("proxy") is the foot on the surface, x - phi n, and both
/// steps of a tick end in the same state, so one evaluation at (x, t) gives
///
///   F = K max(0, -phi(x, t)) n(x, t),   n = grad phi / |grad phi| outward.

#include <cstdint>
#include <memory>
#include <optional>

#include "runtime/field/field_query.h"
#include "runtime/haptics/contact.h"

namespace beatlas::haptics {

enum class TimeMode : std::uint8_t {
  Continuous,  ///< the field's periodic cubic spline in time, evaluated every tick
  Published,   ///< paper A: force at the stored frames, interpolated linearly to the tick
};

struct TwoStepOptions {
  double stiffness_n_per_m = 150;  ///< [N/m] 1..5000: K, uniform
  TimeMode time_mode = TimeMode::Continuous;
  std::optional<double> held_time_s =
      std::nullopt;  ///< the heart stands still at this time: the static model
};

/// K max(0, -distance) n; stiffness [N/m], distance [mm], force [N].
[[nodiscard]] Vec3 contact_force_n(double stiffness_n_per_m, double distance_mm,
                                   const Vec3& normal) noexcept;

/// One user point. Not thread-safe: it remembers the direction of the contact.
class TwoStepModel final : public ForceModel {
 public:
  /// @throws Error{InvalidInput} if there is no field or an option is out of range.
  TwoStepModel(std::shared_ptr<const field::FieldQuery> field, const TwoStepOptions& options);

  /// @param x workspace [mm]; t [s].
  /// Deeper than the field knows directions (FieldSample::in_band), the direction of the contact is
  /// the last one known while in contact; with none, away from the structure's centre.
  [[nodiscard]] Contact evaluate(const Vec3& x, double t) noexcept;

  [[nodiscard]] Contact evaluate(const ServoState& state, const Moment& moment) noexcept override;

  void reset() noexcept override { has_direction_ = false; }
  [[nodiscard]] ModelMemory memory() const noexcept override;
  void restore(const ModelMemory& memory) noexcept override;

 private:
  [[nodiscard]] Contact at(const Vec3& x, double t) const noexcept;
  [[nodiscard]] Contact between_frames(const Vec3& x, double t) const noexcept;

  std::shared_ptr<const field::FieldQuery> field_;
  TwoStepOptions options_;
  Vec3 direction_ = Vec3::Zero();
  bool has_direction_ = false;
};

}  // namespace beatlas::haptics
