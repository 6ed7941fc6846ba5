#pragma once
/// What lies around the heart and does not move: skin fat, chest muscle, lungs, liver, descending
/// aorta, spine. Each is one convex body painted over those before it, the heart over all.

#include <vector>

#include "pipeline/phantom/anatomy.h"
#include "pipeline/phantom/signals.h"

namespace beatlas::phantom {

/// Signed distance [mm], negative inside, and its gradient; or a plane that stands for a surface.
struct SignedPlane {
  double distance_mm = 0;
  Vec3 outward = Vec3::UnitZ();
};

/// A body of the thorax; patient LPS. A cylinder stands for what goes on along z.
struct ThoraxBody {
  Ellipsoid body;
  double signal = 0;

  [[nodiscard]] SignedPlane surface(const Vec3& lps) const;  ///< exact
};

/// In painting order. Placed relative to the heart frame's origin; grows with a heart whose scale
/// is above 1 so that no heart touches liver, spine or chest wall, but for a liver that was raised.
[[nodiscard]] std::vector<ThoraxBody> thorax(const Anatomy& anatomy, const Signals& signals);

}  // namespace beatlas::phantom
