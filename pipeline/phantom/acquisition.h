#pragma once
/// Where and when each slice of a phantom was imaged: what the scanner's random faults came to.

#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/phantom/spec.h"

namespace beatlas::phantom {

struct SliceAcquisition {
  double shift_i_mm = 0;  ///< the whole anatomy moves so far along the grid's axis i in this slice
  double shift_j_mm = 0;
  bool mistriggered = false;
  /// Frame p shows time p / phases of the R-R interval plus offset_s[p]; whole milliseconds. Under
  /// its nominal time it is written nevertheless.
  std::vector<double> offset_s;
};

/// One entry a slice. Shifts: normal along i and j, shortened to at most shift_limit_mm. Offsets:
/// normal, at most four sigma, and mistrigger_s in the slices that drew the lowest numbers.
[[nodiscard]] std::vector<SliceAcquisition> acquisition(const PhantomSpec& spec);

/// {"slices": [{"shift_mm": [i, j], "mistriggered", "offset_s": [one a phase]}], "definition":
/// text}
[[nodiscard]] nlohmann::json acquisition_json(const PhantomSpec& spec);

/// The imaging grid as it lies to the anatomy in slice k: moved against the slice's shift.
[[nodiscard]] Grid shifted_grid(const Grid& grid, const SliceAcquisition& slice);

/// Moments [s] that frame `phase` of the slice averages over.
[[nodiscard]] std::vector<double> frame_moments_s(const PhantomSpec& spec,
                                                  const SliceAcquisition& slice, int phase);

}  // namespace beatlas::phantom
