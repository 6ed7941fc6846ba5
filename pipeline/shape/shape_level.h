#pragma once
/// One phase of a structure as a level on the lattice of its shape, from what its voxels or slices
/// hold. The source's axes are parallel to the lattice's.

#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/shape/apical_end.h"
#include "pipeline/shape/section_path.h"

namespace beatlas::shape {

using Phase = std::vector<float>;

/// Where lattice lines of the workspace fall in the source: the axes are parallel, so each source
/// index depends on one workspace coordinate only.
struct AxisMap {
  Vec3 scale;
  Vec3 shift;
  [[nodiscard]] double index(int axis, double lattice) const {
    return scale[axis] * lattice + shift[axis];
  }
};
[[nodiscard]] AxisMap axis_map(const Grid& source, const Grid& lattice,
                               const Affine& workspace_from_lps);

/// Value at a fractional index in plane, linear, clamped to the slice.
[[nodiscard]] float sample_plane(const float* slice, int nx, int ny, double i, double j);

enum class Creases { Keep, Round };

/// For slices close enough that coverage itself shows where between them the surface runs: 1/2 less
/// the coverage, in slices parted by sub_slices.h, cubic between voxels, smoothed. Neither
/// smoothing nor that voxels hold means moves a curved surface: of a ball of 25 mm radius in voxels
/// of 1 x 1 x 3 mm the mean error is -0.001 mm, root mean square 0.004.
/// @param creases Round where some of the surface is only a seam of labels
[[nodiscard]] Phase level_from_coverage(const Grid& source, const Phase& coverage,
                                        const Grid& lattice, const AxisMap& map, Creases creases);

/// Level [mm] from the in-plane distances of the slices (shape interpolation), cubic between four
/// slices and linear between two, along the path of its sections, smoothed. Towards a slice without
/// the structure it closes roundly within half a gap, but on the base's side, where it is carried
/// on to be cut flat; beyond its most apical slice where `apex` says, also where the stack ends
/// there.
/// @param path see section_path.h  @param open_step of the structure's ValvePlane, 0 without one
[[nodiscard]] Phase level_from_slices(const Grid& source, const std::vector<Phase>& distances,
                                      const SectionPath& path, const Grid& lattice,
                                      const AxisMap& map, int open_step, const ApicalEnd& apex);

/// Takes the lid off a wall's open end. What is cavity in one slice and outside of the wall in the
/// next toward the base is the base itself; interpolated apart, the two contours would leave a film
/// of wall between them: wall = max(wall, min(-cavity of the one, outside of the other)), which
/// changes nothing in the slices themselves.
/// @param outer, cavity in-plane distances of each slice, of wall and cavity together and of the
/// cavity; empty: it is not there  @param open_step of the slice index, toward the base
void open_toward_base(Phase& wall, const Grid& source, const std::vector<Phase>& outer,
                      const std::vector<Phase>& cavity, const SectionPath& path,
                      const Grid& lattice, const AxisMap& map, int open_step);

/// Raises the level beyond a plane of constant slice index, so that the shape ends flat there.
/// @param step +1: beyond is at larger index, -1: smaller
void cut_flat(Phase& level, const Grid& lattice, const AxisMap& map, double slice_mm, double at_k,
              int step);

/// Raises the level beyond the rim of the slices' pixels, so that the shape ends there: a distance
/// is read beyond the rim as at it.
void cut_beside(Phase& level, const Grid& lattice, const AxisMap& map, const Grid& source);

}  // namespace beatlas::shape
