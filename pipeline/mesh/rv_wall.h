#pragma once
/// How thick the RV's free wall is, vertex by vertex, where images resolve it.

#include <vector>

#include "pipeline/core/shapes.h"
#include "pipeline/mesh/surface_map.h"

namespace beatlas::mesh {

/// The way from each vertex of the RV's endocardium along its outward normal to the outside of the
/// heart. [mm], 0 where there is no such wall or the images do not resolve it:
/// - the way leads through the LV or its muscle (the septum and its ends), leaves the heart above
///   the tricuspid plane (the right atrium is no wall) or at a slant, or is longer than 15 mm;
/// - the way is shorter than two voxels along it. A layer two voxels thick has a voxel wholly its
///   own wherever the lattice lies; of a thinner one no voxel need show the wall's own grey, and
///   where it ends is told by both its neighbours. So a mean over what is told is one of the
///   thicker part of the wall, not of all of it;
/// - two voxels along the way are more than a normal wall is thick, 5 mm (Rudski et al. 2010): of
///   walls that are mostly too thin to be seen, those that seem thick enough are mostly errors.
/// Atria that are known change nothing: a map is the same with them and without.
/// @param rv of the same phases as the fields
/// @param frame with the tricuspid plane of every phase
/// @return [vertex] of `phase`; all 0 without a field of the heart or a tricuspid plane
[[nodiscard]] std::vector<double> rv_wall_mm(const std::vector<FieldCycle>& fields,
                                             const SurfaceCycle& rv, std::size_t phase,
                                             const MapFrame& frame);

}  // namespace beatlas::mesh
