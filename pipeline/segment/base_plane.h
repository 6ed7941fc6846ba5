#pragma once
/// Where, between and within thick slices, a ventricle ends and its atrium begins.

#include <optional>
#include <vector>

#include "pipeline/core/grid.h"
#include "runtime/atlas/structures.h"

namespace beatlas::segment {

struct BasePlaneSearch {
  const ImageCycle<float>& images;
  const ImageCycle<std::uint8_t>& labels;  ///< of the same grid
  int middle_k = 0;                        ///< a slice that is ventricle in every phase
  int base_step = 0;                       ///< +1 if the base lies towards larger k, -1 if smaller
  double contrast = 0;                     ///< of blood over muscle
  double threshold = 0;                    ///< between them
};

/// A slice through which the base plane passes shows a mixture of what its neighbours show: the
/// ventricle on one side, atrium, fat and lung on the other, and the share of the mixture is the
/// place of the plane within the slice. It is told by the pixels of the ventricle (`region`, in the
/// neighbour's labels) that change across the plane; of their shares the lower quarter counts,
/// because fat in the groove between ventricle and atrium passes for more of the ventricle.
/// `under_fat`: for a ventricle that fat covers all over, the RV. Fat is as bright as its blood, so
/// the plane is taken lower by as much fat as lies on its free wall.
/// @return slice index of the plane, fractional, in every phase; half a gap beyond the stack where
/// the ventricle reaches its end. None if the slices beyond the middle are no such mixtures.
[[nodiscard]] std::optional<std::vector<double>> base_plane_by_mixture(
    const BasePlaneSearch& search, const std::vector<std::uint8_t>& region, bool under_fat);

}  // namespace beatlas::segment
