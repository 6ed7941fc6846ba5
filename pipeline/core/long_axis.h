#pragma once
/// The left ventricle's long axis, and where along it the ventricles begin and end.

#include <optional>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas {

/// Patient LPS [mm]. The axis stands still while the planes move: heights are along `towards_base`
/// from `origin_mm`, which lies in mid-ventricle.
struct LongAxis {
  Vec3 origin_mm = Vec3::Zero();
  Vec3 towards_base = Vec3::UnitZ();  ///< of length 1
  std::vector<double> apex_mm;        ///< [phase] height of the wall's apical end
  std::vector<double> lv_base_mm;     ///< [phase] height at which the LV ends at its mitral plane
  std::vector<double> rv_base_mm;     ///< [phase] height of the tricuspid plane; empty without RV
  bool atria = false;  ///< atria or the aorta lie beyond the base as structures of their own
  /// The middle of the RV's blood in the first phase: segments are counted from the septum, which
  /// lies towards it. None without an RV.
  std::optional<Vec3> rv_centre_mm = {};

  [[nodiscard]] double height_mm(const Vec3& lps_mm) const {
    return towards_base.dot(lps_mm - origin_mm);
  }

  /// Where a place lies in the LV: 0 at the apex, 1 at the base, beyond outside.
  [[nodiscard]] double share_of_length(const Vec3& lps_mm, int phase) const {
    const auto p = static_cast<std::size_t>(phase);
    return (height_mm(lps_mm) - apex_mm[p]) / (lv_base_mm[p] - apex_mm[p]);
  }
};

}  // namespace beatlas
