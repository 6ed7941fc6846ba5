#pragma once
/// A tube that moves with the heart: the way through a valve, for a tool that passes it.

#include <vector>

#include "runtime/haptics/contact_field.h"

namespace beatlas::haptics {

/// A valve's opening at one moment of the cycle; workspace frame.
struct Opening {
  Vec3 centre_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< unit, out of the cavity
  double radius_mm = 0;         ///< > 0
};

struct TubeOptions {
  double inward_mm = 10;   ///< >= 0: how far its axis goes into the cavity
  double outward_mm = 30;  ///< >= 0: and out of it
};

/// All places nearer to a piece of the opening's axis than its radius: a tube with round ends.
/// Between phases centre, normal and radius follow Catmull and Rom's spline (1974).
class TubeField final : public ContactField {
 public:
  /// @param phases evenly spaced over the cycle  @param period_s [s] > 0
  /// @throws Error{InvalidInput} if there is no phase, or one has no normal or no radius.
  TubeField(std::vector<Opening> phases, double period_s, const TubeOptions& options = {});

  [[nodiscard]] FieldSample sample(const Vec3& x, double t) const noexcept override;
  /// Away from the axis of the first phase.
  [[nodiscard]] Vec3 outward(const Vec3& x) const noexcept override;
  [[nodiscard]] double resolution_mm() const noexcept override { return least_radius_mm_; }
  /// Directions are known everywhere.
  [[nodiscard]] double reach_mm() const noexcept override { return 1000; }
  [[nodiscard]] double period_s() const noexcept override { return period_s_; }

  [[nodiscard]] double least_radius_mm() const noexcept { return least_radius_mm_; }
  /// Where the opening is at a time.
  [[nodiscard]] Opening at(double t) const noexcept;

 private:
  /// The opening at a time, and how it changes [1/s].
  struct Moving {
    Opening now;
    Opening rate;
  };
  [[nodiscard]] Moving moving_at(double t) const noexcept;

  std::vector<Opening> phases_;
  double period_s_;
  TubeOptions options_;
  double least_radius_mm_ = 0;
};

}  // namespace beatlas::haptics
