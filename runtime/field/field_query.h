#pragma once
#include <memory>

#include "runtime/atlas/payloads.h"
#include "runtime/base/geometry.h"

namespace beatlas::field {

/// The field at one point and time; workspace frame.
struct FieldSample {
  double distance_mm = 0;        ///< negative inside; clamped outside the band, its sign right
  Vec3 gradient = Vec3::Zero();  ///< d phi / d x, about unit length in the band, 0 far from it
  double rate_mm_s = 0;          ///< d phi / d t; the surface moves with -rate / |gradient| along n
  bool in_band = false;          ///< false where distance is clamped and gradient is no direction
};

/// Evaluates a FieldPayload: C2 in space and time. Immutable and thread-safe.
class FieldQuery {
 public:
  /// @param rr_interval_s [s] > 0
  FieldQuery(std::shared_ptr<const atlas::FieldPayload> payload, double rr_interval_s);

  /// @param x workspace [mm], any point; t [s], any time (taken modulo the R-R interval)
  [[nodiscard]] FieldSample sample(const Vec3& x, double t) const noexcept;

  [[nodiscard]] double rr_interval_s() const noexcept { return rr_interval_s_; }

 private:
  std::shared_ptr<const atlas::FieldPayload> payload_;
  double rr_interval_s_;
};

}  // namespace beatlas::field
