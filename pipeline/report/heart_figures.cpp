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

const std::vector<NormalSource>& normal_sources() {
  static const std::vector<NormalSource> sources{
      {"Petersen 2017",
       "Petersen SE et al. Reference ranges for cardiac structure and function using "
       "cardiovascular magnetic resonance (CMR) in Caucasians from the UK Biobank population "
       "cohort. J Cardiovasc Magn Reson 2017;19:18. doi:10.1186/s12968-017-0327-9",
       "healthy adults of 45 to 74 years, SSFP cine at 1.5 T, papillary muscles counted as blood"},
      {"Hudsmith 2005",
       "Hudsmith LE et al. Normal human left and right ventricular and left atrial dimensions "
       "using steady state free precession magnetic resonance imaging. J Cardiovasc Magn Reson "
       "2005;7:775-782. doi:10.1080/10976640500295516",
       "63 men and 45 women, SSFP cine at 1.5 T; mean and twice the standard deviation"},
      {"Kawel-Boehm 2015",
       "Kawel-Boehm N et al. Normal values for cardiovascular magnetic resonance in adults and "
       "children. J Cardiovasc Magn Reson 2015;17:29. doi:10.1186/s12968-015-0111-7",
       "pooled healthy adults, SSFP cine, papillary muscles counted as muscle, which adds to the "
       "mass; mean and twice the standard deviation"}};
  return sources;
}

const std::vector<NormalRange>& normal_ranges() {
  static const std::vector<NormalRange> ranges{
      {"lv_ef_percent", "LV ejection fraction", "%", 47, 70, 51, 70, 0},
      {"lv_edv_ml", "LV end-diastolic volume", "ml", 109, 232, 88, 161, 0},
      {"lv_esv_ml", "LV end-systolic volume", "ml", 39, 103, 31, 68, 0},
      {"lv_sv_ml", "LV stroke volume", "ml", 58, 140, 49, 100, 0},
      {"rv_edv_ml", "RV end-diastolic volume", "ml", 124, 256, 78, 218, 1},
      {"rv_esv_ml", "RV end-systolic volume", "ml", 38, 118, 20, 92, 1},
      {"lv_mass_g", "LV mass", "g", 92, 176, 56, 140, 2}};
  return ranges;
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
