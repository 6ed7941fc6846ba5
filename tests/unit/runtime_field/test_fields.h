#pragma once
/// Closed forms and payloads for the tests of what reads a field. Independent of the pipeline:
/// the prefilter here is a fixed-point iteration, not the recursive filter of encode_field.

#include <functional>
#include <memory>

#include "runtime/atlas/payloads.h"

namespace beatlas::testing {

/// phi(x, t) [mm]; workspace [mm], [s].
using Distance = std::function<double(const Vec3&, double)>;

/// Signed distance to an axis-aligned ellipsoid about the origin with semi-axes `axes`; by
/// bisection on the Lagrange multiplier (Eberly, "Distance from a point to an ellipsoid"). [mm]
double ellipsoid_distance(const Vec3& axes, const Vec3& x);
/// Nearest point of the ellipsoid's surface to x.
Vec3 ellipsoid_nearest(const Vec3& axes, const Vec3& x);

struct LatticeSpec {
  Vec3 origin_mm = Vec3::Zero();
  double voxel_mm = 1.5;
  Index3 blocks{4, 4, 4};
  int phases = 15;
  double rr_interval_s = 0.75;
  double step_mm = 0.002;
  double inner_mm = 60;
  double outer_mm = 60;
};

/// Every sample active, prefiltered so that the spline interpolates `phi` at the samples.
std::shared_ptr<atlas::FieldPayload> dense_payload(const LatticeSpec& spec, const Distance& phi);

}  // namespace beatlas::testing
