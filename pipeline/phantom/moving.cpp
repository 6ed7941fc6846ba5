#include "pipeline/phantom/moving.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace beatlas::phantom {
namespace {

/// A ball about the part, if the shape has a simple one.
void set_ball(const HeartShape& shape, const Affine& lps_from_heart, Part part, Body& body) {
  const auto about = [&](const Ellipsoid& ellipsoid) {
    body.ball_mm = lps_from_heart * ellipsoid.centre_mm;
    body.ball_radius_mm = ellipsoid.semi_axes_mm.maxCoeff();
  };
  switch (part) {
    case Part::LvBlood:
      if (!shape.infarct) about(shape.lv_cavity);
      break;
    case Part::PapillaryMuscles:
      about(shape.lv_cavity);
      break;
    case Part::RvBlood:
      about(shape.rv_cavity);
      break;
    case Part::LaBlood:
      about(shape.la->blood);
      break;
    case Part::RaBlood:
      about(shape.ra->blood);
      break;
    case Part::Aorta: {
      const AortaShape& aorta = *shape.aorta;
      const double half_mm = 0.5 * (aorta.top_z_mm - shape.lv_base_z_mm);
      Vec3 middle = aorta.lumen.centre_mm;
      middle.z() = shape.lv_base_z_mm + half_mm;
      body.ball_mm = lps_from_heart * middle;
      body.ball_radius_mm = std::hypot(half_mm, aorta.lumen.semi_axes_mm.x());
      break;
    }
    default:
      break;
  }
}

}  // namespace

std::vector<Body> moving_bodies(const Frame& frame, const Affine& lps_from_heart) {
  std::vector<Body> out;
  for (const MovingBody& moving : kMovingBodies) {
    const Part part = moving.part;
    Body body;
    const bool held = moving.within >= 0 && frame.has(kMovingBodies[moving.within].part);
    body.within = held ? moving.within : -1;
    if (frame.has(part)) {
      body.surface = [&frame, part](const Vec3& lps) {
        const Nearest nearest = frame.nearest(part, lps);
        return SignedPlane{nearest.distance_mm, nearest.outward};
      };
      body.inside = [&frame, part](const Vec3& lps) { return frame.contains(part, lps); };
      set_ball(frame.shape(), lps_from_heart, part, body);
    } else {
      body.ball_radius_mm = -std::numeric_limits<double>::infinity();  // nothing is in it
    }
    out.push_back(std::move(body));
  }
  return out;
}

double moving_signal(const Shares& shares, double behind, double blood, const Signals& signals) {
  std::array<double, 4> layer{};  // share of each, its inner ones included
  for (std::size_t n = 0; n < kMovingBodies.size(); ++n) {
    layer[static_cast<std::size_t>(kMovingBodies[n].layer)] += shares[n];
  }
  auto& [fat, muscle, pools, papillary] = layer;
  pools = std::min(pools, 1.0);
  papillary = std::min(papillary, pools);
  muscle = std::clamp(muscle, pools, 1.0);
  fat = std::clamp(fat, muscle, 1.0);
  return (1.0 - fat) * behind + (fat - muscle) * signals.fat +
         (muscle - pools) * signals.myocardium + (pools - papillary) * blood +
         papillary * signals.myocardium;
}

}  // namespace beatlas::phantom
