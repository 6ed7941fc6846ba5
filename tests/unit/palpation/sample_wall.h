#pragma once
/// A left ventricle in closed form: a ball that beats, its wall thin on one side.

#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "runtime/palpation/lv_wall.h"
#include "runtime/palpation/segments.h"
#include "tests/unit/unit_sphere.h"

namespace beatlas::palpation::test {

inline constexpr double kRadiusMm = 25;

/// Radius over the beat: 25 mm at phase 0, 20 in mid-cycle. z is the long axis, the anterior wall
/// towards x, the septum towards y.
struct SampleWall {
  explicit SampleWall(int phases = 4, int levels = 4) {
    const auto [points, triangles] = beatlas::test::unit_sphere(levels);
    surface->structure = map->structure = Structure::LvBlood;
    surface->triangles = triangles;
    surface->positions.resize(static_cast<std::size_t>(phases));
    map->thickness_mm.resize(static_cast<std::size_t>(phases));
    for (const Vec3& unit : points) {
      const double s = 0.5 + 0.5 * unit.z();
      double angle = std::atan2(unit.y(), unit.x());
      if (angle < 0) angle += 2 * std::numbers::pi;
      map->long_axis.push_back(static_cast<float>(s));
      map->angle_rad.push_back(static_cast<float>(angle));
      map->segment.push_back(static_cast<std::uint8_t>(segment_at(s, angle)));
      for (int p = 0; p < phases; ++p) {
        const double beat = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * p / phases);
        const auto n = static_cast<std::size_t>(p);
        surface->positions[n].push_back(((kRadiusMm - 5 * beat) * unit).cast<float>());
        // No wall on the flat end of the base; 4 mm where x is positive, 10 elsewhere.
        map->thickness_mm[n].push_back(unit.z() > 0.9 ? 0.0F : unit.x() > 0 ? 4.0F : 10.0F);
      }
    }
  }
  [[nodiscard]] LvWall wall() const { return {surface, map, 0}; }

  std::shared_ptr<atlas::SurfacePayload> surface = std::make_shared<atlas::SurfacePayload>();
  std::shared_ptr<atlas::SurfaceMapPayload> map = std::make_shared<atlas::SurfaceMapPayload>();
};

}  // namespace beatlas::palpation::test
