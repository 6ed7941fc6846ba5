#include "pipeline/report/heart_figures.h"

#include <algorithm>
#include <numeric>

namespace beatlas::report {
namespace {

const std::vector<double>* curve_of(const std::vector<VolumeCurve>& volumes, Structure structure) {
  for (const VolumeCurve& curve : volumes) {
    if (curve.structure == structure && !curve.volume_ml.empty()) return &curve.volume_ml;
  }
  return nullptr;
}

std::optional<VentricleFigures> ventricle(const std::vector<double>* volume_ml) {
  if (volume_ml == nullptr) return {};
  const auto [low, high] = std::minmax_element(volume_ml->begin(), volume_ml->end());
  return VentricleFigures{*high, *low, static_cast<int>(high - volume_ml->begin()),
                          static_cast<int>(low - volume_ml->begin())};
}

}  // namespace

HeartFigures heart_figures(const std::vector<VolumeCurve>& volumes) {
  HeartFigures out;
  out.lv = ventricle(curve_of(volumes, Structure::LvBlood));
  out.rv = ventricle(curve_of(volumes, Structure::RvBlood));
  if (const auto* muscle = curve_of(volumes, Structure::LvMyocardium)) {
    const std::size_t at = out.lv ? static_cast<std::size_t>(out.lv->ed) : 0;
    out.lv_mass_g = kMuscleGPerMl * muscle->at(at);
    const auto [low, high] = std::minmax_element(muscle->begin(), muscle->end());
    const double mean =
        std::accumulate(muscle->begin(), muscle->end(), 0.0) / static_cast<double>(muscle->size());
    if (mean > 0) out.muscle_change_percent = 100 * (*high - *low) / mean;
  }
  return out;
}

HeartFigures ventricles_at(const HeartFigures& figures, const std::vector<VolumeCurve>& volumes) {
  const auto at = [&](const std::optional<VentricleFigures>& of, Structure structure) {
    const std::vector<double>* curve = curve_of(volumes, structure);
    std::optional<VentricleFigures> out;
    if (!of || curve == nullptr) return out;
    const auto last = static_cast<int>(curve->size()) - 1;
    if (std::max(of->ed, of->es) > last) return out;
    out = {(*curve)[static_cast<std::size_t>(of->ed)], (*curve)[static_cast<std::size_t>(of->es)],
           of->ed, of->es};
    return out;
  };
  HeartFigures out;
  out.lv = at(figures.lv, Structure::LvBlood);
  out.rv = at(figures.rv, Structure::RvBlood);
  return out;
}

std::optional<double> figure_of(const HeartFigures& figures, const std::string& key) {
  if (key == "lv_mass_g") return figures.lv_mass_g;
  const std::optional<VentricleFigures>& of = key.starts_with("rv") ? figures.rv : figures.lv;
  if (!of) return {};
  if (key.ends_with("_ef_percent")) return of->ef_percent();
  if (key.ends_with("_edv_ml")) return of->edv_ml;
  if (key.ends_with("_esv_ml")) return of->esv_ml;
  return of->stroke_ml();
}

}  // namespace beatlas::report
