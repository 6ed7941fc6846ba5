#pragma once
/// Closed-form beating shapes for the mesh tests; share 0 is end-diastole, 1 end-systole.

#include <cmath>
#include <functional>
#include <numbers>

#include "pipeline/field/field.h"
#include "tests/unit/field/closed_form.h"

namespace beatlas::closed_form {

using BeatingLevel = std::function<double(double share, const Vec3& mm)>;

/// Close to the distance near the surface, exactly zero on it.
inline double ellipsoid_level(const Ellipsoid& e, const Vec3& x) {
  const Vec3 q = (x - e.centre_mm).cwiseQuotient(e.radii_mm);
  const double steep = q.cwiseQuotient(e.radii_mm).norm();
  return steep > 1e-9 ? q.norm() * (q.norm() - 1) / steep : -e.radii_mm.minCoeff();
}

inline Ellipsoid beating_ellipsoid(double share) {
  return {{2, -3, -5 + 4 * share}, {25 - 4 * share, 22 - 4 * share, 34 - 5 * share}};
}

/// Two ellipsoids that overlap, moving apart and inward.
inline double two_ellipsoids(double share, const Vec3& x) {
  return std::min(ellipsoid_level({{-8, 0, -4}, {20 - 4 * share, 19 - 4 * share, 30}}, x),
                  ellipsoid_level({{12 - share, 3, 0}, {16 - 3 * share, 20, 24 - 3 * share}}, x));
}

/// Left ventricular muscle: a thick cup, its base plane 14 mm lower at end-systole.
inline double cup(double share, const Vec3& x) {
  const double a = 27 - 9.6 * share;
  const double c = 62 - 10.8 * share;
  const double wall = 8.5 + 4.9 * share;
  const double apex = 6 + 2 * share;
  const Vec3 y = x - Vec3(0, 0, -68 + apex + c);
  return std::max({ellipsoid_level({{0, 0, 0}, {a + wall, a + wall, c + apex}}, y),
                   -ellipsoid_level({{0, 0, 0}, {a, a, c}}, y), y.z() - 30 + 5.2 * share});
}

/// A right ventricle: a crescent with a thin rim, its base 22 mm lower at end-systole.
inline double crescent(double share, const Vec3& x) {
  const double a = 35.5 - 4.7 * share;
  const double c = 68 - 8.8 * share;
  const double septum = ellipsoid_level({{0, 0, 0}, {a, a, c}}, x);
  const double free_wall = ellipsoid_level(
      {{28 - 6 * share, 0, -2 - 6 * share}, {32.5 - 6.3 * share, 44 - 8 * share, 62 - 10 * share}},
      x);
  return std::max({free_wall, -septum, x.z() - 32 + 22 * share});
}

inline FieldCycle beating_field(const BeatingLevel& level, int phases, const Vec3& low_mm,
                                const Vec3& high_mm,
                                field::Handles handles = field::Handles::Close) {
  ShapeCycle shape;
  shape.level.grid = lattice(low_mm, high_mm, 1.0);
  for (int p = 0; p < phases; ++p) {
    const double share = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * p / phases);
    shape.level.phases.push_back(
        sampled(shape.level.grid, [&](const Vec3& x) { return level(share, x); }));
  }
  StageContext context;
  field::FieldOptions options;
  options.handles = handles;
  return field::build_field(shape, options, context);
}

}  // namespace beatlas::closed_form
