#pragma once
#include <string>
#include <vector>

#include "runtime/atlas/structures.h"

namespace beatlas::report {

struct VolumeCurve {
  Structure structure{};
  std::vector<double> volume_ml;  ///< one value a phase
};

/// Volume over the cycle of each structure as a self-contained SVG; end-diastole and end-systole
/// are marked. The curve is drawn closed: phase N is phase 0 again, at the R-R interval.
/// @throws Error{InvalidInput} if curves are empty or differ in length.
[[nodiscard]] std::string volume_curves_svg(const std::vector<VolumeCurve>& curves,
                                            double rr_interval_s, int end_diastole,
                                            int end_systole);

}  // namespace beatlas::report
