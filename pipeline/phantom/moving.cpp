#include "pipeline/phantom/moving.h"

#include <algorithm>
#include <array>

namespace beatlas::phantom {
namespace {

/// A ball about the body, if the shape has a simple one.
void set_ball(const HeartShape& shape, const Affine& lps_from_heart, Structure structure,
              Body& body) {
  const auto about = [&](const Ellipsoid& ellipsoid) {
    body.ball_mm = lps_from_heart * ellipsoid.centre_mm;
    body.ball_radius_mm = ellipsoid.semi_axes_mm.maxCoeff();
  };
  if (structure == Structure::LvBlood) about(shape.lv_cavity);
  if (structure == Structure::RvBlood) about(shape.rv_cavity);
}

}  // namespace

std::vector<Body> moving_bodies(const Frame& frame, const Affine& lps_from_heart) {
  std::vector<Body> out;
  for (const MovingBody& moving : kMovingBodies) {
    const Structure structure = moving.structure;
    Body body;
    body.surface = [&frame, structure](const Vec3& lps) {
      const Nearest nearest = frame.nearest(structure, lps);
      return SignedPlane{nearest.distance_mm, nearest.outward};
    };
    body.inside = [&frame, structure](const Vec3& lps) { return frame.contains(structure, lps); };
    body.within = moving.within;
    set_ball(frame.shape(), lps_from_heart, structure, body);
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
