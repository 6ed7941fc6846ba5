#pragma once
/// The left ventricle's wall of an atlas: which muscle lies under a place of the heart.

#include <cstdint>
#include <memory>
#include <vector>

#include "runtime/atlas/atlas.h"
#include "runtime/atlas/payloads.h"
#include "runtime/base/geometry.h"

namespace beatlas::palpation {

/// The vertex of the endocardium nearest to a place.
struct WallPlace {
  std::uint32_t vertex = 0;
  double away_mm = 0;    ///< from the place to it
  double long_axis = 0;  ///< 0 apex .. 1 base
  int segment = 0;       ///< 1..17
  double wall_mm = 0;    ///< its thickness at end-diastole; 0: there is none, as on the flat base
};

/// The LV's endocardium with its map. Immutable; looked at by any thread.
class LvWall {
 public:
  /// @param endocardium, map of lv_blood of one package
  /// @param end_diastole phase
  /// @throws Error{InvalidInput} if one is missing, they are not of one surface and cycle, or no
  /// vertex has a wall at end-diastole.
  LvWall(std::shared_ptr<const atlas::SurfacePayload> endocardium,
         std::shared_ptr<const atlas::SurfaceMapPayload> map, int end_diastole);

  [[nodiscard]] std::size_t vertex_count() const noexcept { return map_->segment.size(); }
  [[nodiscard]] const atlas::SurfaceMapPayload& map() const noexcept { return *map_; }
  /// [vertex] [mm] at end-diastole; 0: none.
  [[nodiscard]] const std::vector<float>& wall_mm() const noexcept {
    return map_->thickness_mm[end_diastole_];
  }
  /// [mm] of a vertex at the phase nearest to `beats`; 0: none.
  [[nodiscard]] double wall_mm_at(std::uint32_t vertex, double beats) const noexcept;
  /// [vertex] share of the wall's muscle that stands for it: its part of the surface times the
  /// thickness there, at end-diastole; they add up to 1.
  [[nodiscard]] const std::vector<double>& muscle_share() const noexcept { return share_; }

  /// Of a vertex at end-diastole, and the surface's normal there, towards the muscle.
  [[nodiscard]] Vec3 mm(std::uint32_t vertex) const noexcept {
    return endocardium_->positions[end_diastole_][vertex].cast<double>();
  }
  [[nodiscard]] const Vec3& outward(std::uint32_t vertex) const noexcept {
    return outward_[vertex];
  }

  /// A place of the muscle.
  struct Material {
    Vec3 mm = Vec3::Zero();    ///< of it on the endocardium at end-diastole
    std::uint32_t vertex = 0;  ///< the nearest one
  };
  /// What of the endocardium is nearest to a place at `beats` (as `nearest`; between phases the
  /// surface moves straight), vertices without a wall left out. Looks at every triangle: not for a
  /// tick.
  [[nodiscard]] Material material_at(const Vec3& mm, double beats) const;

  /// Of the vertices that have a wall, at the phase nearest to `beats` (time over the R-R
  /// interval, any number). Looks at all of them: some microseconds.
  [[nodiscard]] WallPlace nearest(const Vec3& mm, double beats) const noexcept;
  /// The same for a place that has moved a little since it was at `from`: goes downhill from vertex
  /// to vertex, which takes a fraction of a microsecond. May end on one without a wall.
  [[nodiscard]] WallPlace near(const Vec3& mm, double beats, std::uint32_t from) const noexcept;

  /// What `follow` remembers from call to call.
  struct Trail {
    std::uint32_t vertex = 0;  ///< where it was
    std::uint32_t looked = 0;  ///< how far it has looked around
  };
  /// The nearest place that has a wall, for a tick: downhill from where the trail is, and 32
  /// vertices more are looked at, all of them in turn, so that wherever it began, and after a jump,
  /// it is there some hundred calls later.
  [[nodiscard]] WallPlace follow(const Vec3& mm, double beats, Trail& trail) const noexcept;

  /// The vertex in the middle of a segment's wall at end-diastole.
  /// @throws Error{InvalidInput} if no vertex with a wall is of that segment
  [[nodiscard]] std::uint32_t middle_of(int segment) const;

 private:
  [[nodiscard]] std::size_t phase_of(double beats) const noexcept;
  [[nodiscard]] const std::vector<Vec3f>& positions(double beats) const noexcept;
  [[nodiscard]] WallPlace place(std::uint32_t vertex, double away2_mm2) const noexcept;

  std::shared_ptr<const atlas::SurfacePayload> endocardium_;
  std::shared_ptr<const atlas::SurfaceMapPayload> map_;
  std::size_t end_diastole_;
  std::vector<double> share_;
  std::vector<Vec3> outward_;                   ///< [vertex] of unit length
  std::vector<std::uint32_t> first_neighbour_;  ///< [vertex + 1] into neighbours_
  std::vector<std::uint32_t> neighbours_;
};

/// A package's, of lv_blood; null where its map was not opened or is not there.
/// @throws Error{InvalidInput} as LvWall, and if the map's surface was not opened.
[[nodiscard]] std::shared_ptr<const LvWall> lv_wall_of(const atlas::Atlas& package);

}  // namespace beatlas::palpation
