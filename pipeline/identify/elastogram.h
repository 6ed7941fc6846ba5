#pragma once
/// How stiff the muscle is, from an image of stiffness (magnetic resonance or ultrasound
/// elastography).

#include <vector>

#include "pipeline/core/grid.h"
#include "runtime/palpation/lv_wall.h"

namespace beatlas::identify {

/// What the voxels of an elastogram are.
enum class Modulus {
  Young,  ///< of elasticity, E
  Shear,  ///< G; E = 3 G, of a tissue that is isotropic, linear and does not change its volume
};

struct ElastogramOptions {
  Modulus modulus = Modulus::Young;
  double kpa_per_unit = 1;  ///< 0.001 where voxels are in Pa
};

/// [vertex] E [kPa] of the wall at end-diastole: the mean along the way through the wall from 1/8
/// to 7/8 of its thickness, every half of the finest voxel or closer, trilinear. Voxels that are
/// not above 0 were not measured; a vertex of which less than half was is 0, as is one without a
/// wall.
/// @param image [voxel] of `grid`, LPS, finite
/// @throws Error{InvalidInput} if less than 5 % of the wall was measured (an image of another
/// heart, or frame) or the median is not 0.05 to 1000 kPa
[[nodiscard]] std::vector<float> elastogram_of_wall(const palpation::LvWall& wall,
                                                    const Affine& workspace_from_lps,
                                                    const Grid& grid,
                                                    const std::vector<float>& image,
                                                    const ElastogramOptions& options);

}  // namespace beatlas::identify
