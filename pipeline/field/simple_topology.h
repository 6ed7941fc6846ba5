#pragma once
#include <cstddef>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::field {

/// Topology of {samples < 0} as marching tetrahedra see it (field/surface.h): the part of the
/// Freudenthal triangulation of the lattice whose corners are all inside, where each sample has
/// 14 neighbours.
struct BodyTopology {
  int pieces = 0;
  int hollows = 0;  ///< pieces of the outside that do not reach the lattice's border
  int handles = 0;

  [[nodiscard]] bool is_ball() const { return pieces == 1 && hollows == 0 && handles == 0; }
};
[[nodiscard]] BodyTopology topology_of(const Grid& grid, const std::vector<float>& samples);

/// What make_ball did to one phase.
struct Repair {
  BodyTopology before;
  std::size_t changed = 0;  ///< samples whose side changed
  int left_handles = 0;     ///< that could not be closed; 0 but for samples that are mere noise
};

/// Changes samples so that their zero surface is one sphere: makes one piece without hollows, see
/// make_one_body, and closes each handle where that changes least, by cutting the loop through or
/// by filling its hole; least is the sum of |samples| that change side. Where to cut and what to
/// fill come from growing the inside from its depth, or the outside from the border, by points that
/// leave the topology as it is (simple points: the inside and the outside each in one piece around
/// the point; Bertrand 1994), nearest to the source first: what cannot be reached is the thinnest
/// section of a loop (Kriegeskorte and Goebel 2001). Samples around a change are eased, so that a
/// cut is about 0.6 of a sample wide. Deterministic.
/// @param samples distances, clamped or not; untouched where they are a ball already
Repair make_ball(const Grid& grid, std::vector<float>& samples);

}  // namespace beatlas::field
