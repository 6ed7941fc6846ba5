#pragma once
/// What of a surface lies beyond the middle between it and another, and its shortest way back.

#include <array>
#include <vector>

#include <Eigen/Geometry>

#include "pipeline/core/shapes.h"
#include "pipeline/field/interpolant.h"
#include "pipeline/mesh/fans.h"

namespace beatlas::mesh {

/// A function of two distances that is positive where a place of the first structure has to go
/// back.
struct Bound {
  double own = 0;
  double other = 0;
};

inline constexpr double kGapMm = 0.01;  ///< of either surface from the middle

/// How far a place is beyond what bounds it.
class Middle {
 public:
  Middle(const field::Interpolant& own, const field::Interpolant& other, const Bound& bound)
      : own_(own), other_(other), bound_(bound) {}

  [[nodiscard]] double beyond(const Vec3& x) const {
    return bound_.own * own_.value(x) + bound_.other * other_.value(x) + kGapMm;
  }
  /// Unit vector the way back; zero where there is none.
  [[nodiscard]] Vec3 back(const Vec3& x) const {
    const Vec3 slope =
        bound_.own * own_.sample(x).gradient + bound_.other * other_.sample(x).gradient;
    const double steep = slope.norm();
    return steep > 0.3 ? Vec3(-slope / steep) : Vec3(Vec3::Zero());
  }

 private:
  const field::Interpolant& own_;
  const field::Interpolant& other_;
  Bound bound_;
};

/// Of one of two structures: what comes near the other.
struct Side {
  std::vector<std::uint32_t> vertices;
  std::vector<std::uint32_t> triangles;
  bool known = false;
  /// What was found of them last, how far beyond the middle [mm]: of those that moved since, and of
  /// their triangles, it is asked again.
  std::vector<double> vertex_beyond;
  std::vector<std::array<double, 4>> triangle_beyond;  ///< its middle, its edges' from corner 0 on
  std::vector<bool> asked;                             ///< [triangle]
  int seen = -1;                                       ///< moves of the body then
};

/// A structure in one phase.
struct Body {
  SurfaceCycle* surface;
  const Fans* fans;
  field::Interpolant field;
  std::vector<Vec3> points;
  std::vector<Vec3> start;
  std::vector<std::uint32_t> off;  ///< triangles that are off the structure's surface
  Eigen::AlignedBox3d box;         ///< and what lies near it
  Eigen::AlignedBox3d changed;     ///< triangles that moved since crossings were looked for
  std::vector<int> moved;          ///< [vertex] at which of the body's moves last
  int moves = 0;

  [[nodiscard]] Structure structure() const { return surface->structure; }
  [[nodiscard]] const std::vector<Triangle>& triangles() const { return surface->triangles; }
  [[nodiscard]] Eigen::AlignedBox3d box_of(const Triangle& t) const {
    return Eigen::AlignedBox3d(points[t[0]]).extend(points[t[1]]).extend(points[t[2]]);
  }
};

/// [mm] from the middle: no triangle of a vertex there reaches it.
inline constexpr double kFarMm = 1.0;
/// How often draw_back may be asked before vertices may be near that look_around left out.
inline constexpr int kPartRounds = 5;

/// Finds what comes near the middle, the first time that it is asked.
void look_around(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles,
                 const Middle& middle, Side& side);

/// Moves what is beyond the middle back, vertices, edges and triangles, by the least sum of
/// squares.
/// @param side what of the body may demand and move
/// @param more [vertex] [mm] that it has to go beyond the middle
/// @return whether anything moved
[[nodiscard]] bool draw_back(Body& body, const Middle& middle, Side& side,
                             const std::vector<double>& more, double thin_deg);

}  // namespace beatlas::mesh
