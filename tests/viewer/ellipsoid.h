#pragma once
/// A heart in closed form: two ellipsoids about one middle that beat with the cosine of the phase.

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "runtime/atlas/atlas.h"
#include "tests/package/sample_package.h"

namespace beatlas::test {

struct BeatingEllipsoid {
  Vec3 centre_mm{131, 118, 97};
  Eigen::Matrix3d axes = Eigen::AngleAxisd(0.7, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  Vec3 half_mm{48, 36, 31};
  double beat = 0.12;

  [[nodiscard]] double scale(double beats) const {
    return 1 - beat * (0.5 - 0.5 * std::cos(2 * std::numbers::pi * beats));
  }
  /// x is on it: (x - centre)^T shape^-1 (x - centre) = 1.
  [[nodiscard]] Eigen::Matrix3d shape(double beats) const {
    const Vec3 half = scale(beats) * half_mm;
    return axes * half.cwiseAbs2().asDiagonal() * axes.transpose();
  }
  /// Half widths of its section by a plane through the middle with unit axes u, v: where along
  /// cos(a) u + sin(a) v the surface lies.
  [[nodiscard]] double radius_along(double beats, const Vec3& direction) const {
    return 1 / std::sqrt(direction.dot(shape(beats).inverse() * direction));
  }
  /// Of its shadow along u x v, in the direction cos(a) u + sin(a) v.
  [[nodiscard]] double shadow_along(double beats, const Vec3& u, const Vec3& v, double a) const {
    Eigen::Matrix<double, 2, 3> flat;
    flat.row(0) = u.transpose();
    flat.row(1) = v.transpose();
    const Eigen::Matrix2d shadow = flat * shape(beats) * flat.transpose();
    const Vec2 direction(std::cos(a), std::sin(a));
    return 1 / std::sqrt(direction.dot(shadow.inverse() * direction));
  }
};

/// Heart and LV blood (0.55 as large) as such ellipsoids; written and opened again. With images,
/// and a wall of LV blood that is 6 mm thick at the apex and 11 at the base.
/// @param muscle_off > 0: the LV's muscle too, which lies on the heart's surface but for waves of
/// this part of its size, as surfaces fitted each by itself do
/// @param banded the heart's surface is known to 1 mm within slices and to 5 mm across them
inline std::shared_ptr<const atlas::Atlas> ellipsoid_atlas(const TemporaryFolder& folder,
                                                           const BeatingEllipsoid& heart,
                                                           int phases, int levels,
                                                           double muscle_off = 0,
                                                           bool banded = false) {
  pack::PackageContent content = sample_content(phases, 20, 2, 3);
  content.surfaces.clear();
  std::vector<Structure> structures{Structure::Heart, Structure::LvBlood};
  if (muscle_off > 0) {
    structures.push_back(Structure::LvMyocardium);
    content.manifest.structures.push_back(content.manifest.structures.back());
    content.manifest.structures.back().name = structure_name(Structure::LvMyocardium);
  }
  if (banded) {
    const auto slices = static_cast<std::size_t>(content.manifest.source_size[2]);
    const auto everywhere = [&](double mm) {
      return std::vector(static_cast<std::size_t>(phases), std::vector<double>(slices, mm));
    };
    content.manifest.structures.front().band = {everywhere(1), everywhere(5)};
  }
  for (const Structure structure : structures) {
    const double part = structure == Structure::LvBlood ? 0.55 : 1;
    const double off = structure == Structure::LvMyocardium ? muscle_off : 0;
    atlas::SurfacePayload ball = beating_surface(structure, 20, 0, 1, levels);
    Vec3f middle = Vec3f::Zero();
    for (const Vec3f& x : ball.positions[0]) middle += x;
    middle /= static_cast<float>(ball.positions[0].size());
    const std::vector<Vec3f> directions = ball.positions[0];
    ball.positions.assign(static_cast<std::size_t>(phases), {});
    for (int phase = 0; phase < phases; ++phase) {
      const double scale = part * heart.scale(static_cast<double>(phase) / phases);
      for (const Vec3f& x : directions) {
        const Vec3 unit = (x - middle).cast<double>().normalized();
        const double wave = 1 + off * std::sin(9 * unit.x()) * std::cos(7 * unit.y() + unit.z());
        const Vec3 at =
            heart.centre_mm + heart.axes * (wave * scale * heart.half_mm.cwiseProduct(unit));
        ball.positions[static_cast<std::size_t>(phase)].push_back(at.cast<float>());
      }
    }
    content.surfaces.push_back(std::move(ball));
  }
  atlas::SurfaceMapPayload map = beating_map(content.surfaces.back());
  for (std::vector<float>& phase : map.thickness_mm) {
    for (std::size_t v = 0; v < phase.size(); ++v) phase[v] = 6 + 5 * map.long_axis[v];
  }
  content.maps = {map};
  const std::filesystem::path file = folder.path() / "ellipsoid.beatlas";
  pack::write_package(file, content);
  return std::make_shared<const atlas::Atlas>(atlas::Atlas::open(
      file,
      atlas::everything_in(content.manifest.items.empty() ? atlas::Atlas::open(file, {}).manifest()
                                                          : content.manifest)));
}

}  // namespace beatlas::test
