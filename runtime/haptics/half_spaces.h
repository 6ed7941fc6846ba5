#pragma once
/// The small problem at the heart of the proxy: the point nearest to a target among those that a
/// few planes allow.

#include <array>

#include "runtime/base/geometry.h"

namespace beatlas::haptics {

/// The side normal . q >= offset of a plane.
struct HalfSpace {
  Vec3 normal = Vec3::UnitX();  ///< of unit length
  double offset = 0;            ///< [mm]

  [[nodiscard]] double excess(const Vec3& q) const noexcept { return normal.dot(q) - offset; }
};

/// At most three planes: three hold a point in a corner.
class HalfSpaces {
 public:
  static constexpr int kMost = 3;

  [[nodiscard]] int size() const noexcept { return size_; }
  /// Adds one; the oldest makes room.
  void add(const HalfSpace& half_space) noexcept;
  /// Drops those that forbid `point`, which lies on the surface, by more than `tolerance_mm` more
  /// than they forbid `from`, where it was looked for: a step that was cut short has not come to a
  /// plane, which is no reason to give it up. And those that cut off a part of the ball of
  /// `free_mm` about `from`, which is known to be allowed, and those that are nearly parallel to
  /// `normal`.
  void drop_stale(const Vec3& point, const Vec3& from, double free_mm, const Vec3& normal,
                  double tolerance_mm) noexcept;
  /// The allowed point nearest to x. Where the planes leave none, the newest alone is kept to.
  /// @param held set to whether a plane keeps the answer from x.
  [[nodiscard]] Vec3 nearest(const Vec3& x, bool& held) const noexcept;

 private:
  [[nodiscard]] bool allows(const Vec3& q) const noexcept;

  std::array<HalfSpace, kMost> all_;  // oldest first
  int size_ = 0;
};

}  // namespace beatlas::haptics
