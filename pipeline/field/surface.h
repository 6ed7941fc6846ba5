#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::field {

/// Triangles of one surface, counter-clockwise seen from outside; the grid's frame, [mm].
struct TriangleSoup {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Volume [ml] a closed surface encloses (divergence theorem); negative if it points inward.
[[nodiscard]] double enclosed_ml(const TriangleSoup& surface);

/// The zero surface of a level function on an isotropic lattice, made for measuring distances to
/// it: OpenVDB's dual contour (volumeToMesh, adaptivity 0), its vertices and the middles of its
/// faces moved to the zero of the samples' cubic interpolant. Closed: beyond the lattice is
/// outside. Not always manifold where the shape is thinner than a voxel. Empty if all samples have
/// one sign.
[[nodiscard]] TriangleSoup level_surface(const Grid& grid, const std::vector<float>& level);

/// The zero surface of one phase, made to be remeshed: marching tetrahedra on the distance samples
/// (six about the diagonal of every cube), which is a closed 2-manifold whatever the samples are.
/// Triangles are small and uneven; vertices are linear zeros, about 0.05 mm off on curved parts.
/// Islands and inner cavities come as further components. @pre phase exists; the structure does not
/// reach the lattice's border. Empty if all samples have one sign.
[[nodiscard]] TriangleSoup extract_surface(const FieldCycle& field, int phase);

}  // namespace beatlas::field
