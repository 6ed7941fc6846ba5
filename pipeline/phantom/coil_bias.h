#pragma once
#include "pipeline/phantom/spec.h"

namespace beatlas::phantom {

/// Sensitivity of the coil, by which every signal is multiplied before noise.
///
///   b(x) = 1 + share tanh(u . e + 0.3 (u . e1) (u . e2)),  u = (x - origin) / (80 mm k)
///
/// with e a unit vector toward the coil, in front of the chest (drawn within some 25 degrees of
/// it), e1 and e2 two unit vectors across it, origin that of the heart frame and k the larger of 1
/// and the heart's scale. It is 1 at the heart's origin, within 1 +- share everywhere, and comes to
/// nine tenths of that at the chest's wall. It belongs to the scanner: a shifted slice moves in it.
class CoilBias {
 public:
  explicit CoilBias(const PhantomSpec& spec);
  [[nodiscard]] double at(const Vec3& lps) const;
  [[nodiscard]] bool on() const { return share_ > 0.0; }

 private:
  double share_;
  Vec3 origin_;
  double length_mm_;
  Vec3 toward_;
  Vec3 across_;
  Vec3 other_;
};

}  // namespace beatlas::phantom
