#pragma once
/// A left ventricle in closed form: a ball that beats, its wall thin on one side.

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>

#include "runtime/palpation/lv_wall.h"
#include "runtime/palpation/segments.h"

namespace beatlas::palpation::test {

inline constexpr double kRadiusMm = 25;

/// Radius over the beat: 25 mm at phase 0, 20 in mid-cycle. z is the long axis, the anterior wall
/// towards x, the septum towards y.
struct SampleWall {
  explicit SampleWall(int phases = 4, int levels = 4) {
    std::vector<Vec3> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    std::vector<std::array<std::uint32_t, 3>> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                        {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int level = 0; level < levels; ++level) {
      std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
      const auto middle = [&](std::uint32_t a, std::uint32_t b) {
        const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), points.size());
        if (is_new) points.push_back((points[a] + points[b]).normalized());
        return at->second;
      };
      std::vector<std::array<std::uint32_t, 3>> finer;
      for (const auto& [a, b, c] : triangles) {
        const std::uint32_t ab = middle(a, b);
        const std::uint32_t bc = middle(b, c);
        const std::uint32_t ca = middle(c, a);
        finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
      }
      triangles = std::move(finer);
    }
    surface->structure = map->structure = Structure::LvBlood;
    surface->triangles = std::move(triangles);
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
