#pragma once
#include <vector>

#include "pipeline/pack/lattice.h"

namespace beatlas::pack {

/// Carries a clamped signed distance on beyond its clamp, so that a spline through the samples
/// has no kink at the clamp and does not ring inside the band.
///
/// Samples strictly within (-inner_mm, outer_mm) are kept. The others within `region` get the
/// solution of |grad phi| = 1 that goes on from them: Godunov upwind differences, one Gauss-Seidel
/// sweep in each of the eight orders (Zhao, "A fast sweeping method for Eikonal equations", Math.
/// Comp. 74, 2005). Exact for a plane, first order else; never less than the clamp in magnitude. A
/// sample that no kept sample reaches within `region`, and all outside it, keep their value.
void extend_distance(const Lattice& lattice, const SampleMask& region, double voxel_mm,
                     double inner_mm, double outer_mm, std::vector<float>& distance_mm);

/// Whether `distance_mm` is clamped on neither side; one rule for all of encode_field.
[[nodiscard]] inline bool is_in_band(float distance_mm, double inner_mm, double outer_mm) {
  constexpr double kRounding = 1e-5;  // a clamp value may have been rounded to float
  return static_cast<double>(distance_mm) > -inner_mm * (1 - kRounding) &&
         static_cast<double>(distance_mm) < outer_mm * (1 - kRounding);
}

}  // namespace beatlas::pack
