#pragma once
/// What a clinician asks of a beat first.

#include <optional>
#include <string>
#include <vector>

#include "pipeline/report/curves.h"

namespace beatlas::report {

/// Density of muscle [g/ml].
inline constexpr double kMuscleGPerMl = 1.05;

/// Of one ventricle: volumes [ml], ejection fraction [%]. `ed` and `es` are the phases in which its
/// own volume is largest and smallest.
struct VentricleFigures {
  double edv_ml = 0;
  double esv_ml = 0;
  int ed = 0;
  int es = 0;
  [[nodiscard]] double stroke_ml() const { return edv_ml - esv_ml; }
  [[nodiscard]] double ef_percent() const { return edv_ml > 0 ? 100 * stroke_ml() / edv_ml : 0; }
};

struct HeartFigures {
  std::optional<VentricleFigures> lv;
  std::optional<VentricleFigures> rv;
  /// Muscle of the LV at its end-diastole [g].
  std::optional<double> lv_mass_g;
  /// Largest less smallest volume of that muscle in the cycle, of its mean [%].
  std::optional<double> muscle_change_percent;
};

[[nodiscard]] HeartFigures heart_figures(const std::vector<VolumeCurve>& volumes);

/// The ventricles of other curves of the same heart, at the phases that `figures` names: how two
/// that should agree do. A ventricle that either lacks is left out.
[[nodiscard]] HeartFigures ventricles_at(const HeartFigures& figures,
                                         const std::vector<VolumeCurve>& volumes);

/// The figure of that key, if the heart has it.
[[nodiscard]] std::optional<double> figure_of(const HeartFigures& figures, const std::string& key);

}  // namespace beatlas::report
