#include "pipeline/report/prediction_intervals.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

namespace beatlas::report {
namespace {

/// Of one bound: how much of the figure's scale, of what speaks for the bound's side and of what
/// speaks for the other lies between figure and bound.
struct Margin {
  double of_scale;
  double of_own_side;
  double of_other_side;
};

struct Margins {
  const char* key;
  Margin below;
  Margin above;
};

/// Printed by `scripts/fit_intervals`, of 144 drawn hearts (`scripts/score_draws`,
/// seeds 9000 to 9076 and 9200 to 9275).
constexpr std::array<Margins, 9> kMargins{{
    {"lv_edv_ml", {0.000, 0.869, 0.085}, {0.036, 1.503, 0.850}},
    {"lv_esv_ml", {0.021, 0.717, 0.145}, {0.000, 2.159, 1.326}},
    {"lv_sv_ml", {0.000, 0.491, 0.000}, {0.016, 0.797, 0.000}},
    {"lv_ef_percent", {0.000, 0.373, 0.448}, {0.050, 0.202, 0.029}},
    {"rv_edv_ml", {0.000, 1.861, 0.000}, {0.001, 1.605, 1.070}},
    {"rv_esv_ml", {0.007, 2.024, 0.000}, {0.000, 1.219, 0.721}},
    {"rv_sv_ml", {0.000, 0.511, 0.000}, {0.043, 0.156, 0.889}},
    {"rv_ef_percent", {0.000, 0.430, 0.000}, {0.162, 0.000, 0.255}},
    {"lv_mass_g", {0.105, 0.849, 0.275}, {0.000, 1.369, 0.107}},
}};

/// What speaks for more than a figure says, and for less, in the figure's unit.
struct Doubted {
  double scale = 0;
  double more = 0;
  double less = 0;
};

/// Of a structure in one phase; nothing where a person told most of what is labelled.
std::optional<Doubted> volume_doubted(const Segmentation& segmentation, Structure structure,
                                      int phase, double volume_ml) {
  const auto found = segmentation.belief.find(structure);
  if (found == segmentation.belief.end() || volume_ml <= 0) return {};
  const std::vector<SliceBelief>& slices = found->second[static_cast<std::size_t>(phase)];
  if (is_mostly_told(slices)) return {};
  const SliceBelief all = about_labels(slices);
  const double ml = segmentation.labels.grid.spacing_mm()[2] * 1e-3;
  return Doubted{volume_ml, (all.expected_mm2 - all.agreed_mm2) * ml,
                 (all.labelled_mm2 - all.agreed_mm2) * ml};
}

PredictionInterval interval(double figure, const Margins& margins, const Doubted& doubted) {
  const auto margin = [&](const Margin& of, double own, double other) {
    return of.of_scale * doubted.scale + of.of_own_side * own + of.of_other_side * other;
  };
  return {std::max(0.0, figure - margin(margins.below, doubted.less, doubted.more)),
          figure + margin(margins.above, doubted.more, doubted.less)};
}

void put(const std::string& key, double figure, const Doubted& doubted, PredictionIntervals& out) {
  const auto margins = std::find_if(kMargins.begin(), kMargins.end(),
                                    [&](const Margins& of) { return of.key == key; });
  out[key] = interval(figure, *margins, doubted);
}

void put_ventricle(const Segmentation& segmentation, Structure structure,
                   const VentricleFigures& figures, const std::string& name,
                   PredictionIntervals& out) {
  const auto ed = volume_doubted(segmentation, structure, figures.ed, figures.edv_ml);
  const auto es = volume_doubted(segmentation, structure, figures.es, figures.esv_ml);
  if (ed) put(name + "_edv_ml", figures.edv_ml, *ed, out);
  if (es) put(name + "_esv_ml", figures.esv_ml, *es, out);
  if (!ed || !es) return;
  const Doubted stroke{figures.edv_ml, ed->more + es->less, ed->less + es->more};
  put(name + "_sv_ml", figures.stroke_ml(), stroke, out);
  const double percent = 100 / figures.edv_ml;
  const std::string ef = name + "_ef_percent";
  put(ef, figures.ef_percent(), {100, stroke.more * percent, stroke.less * percent}, out);
  out[ef].high = std::min(out[ef].high, 100.0);
}

}  // namespace

bool is_fitted_to(const nlohmann::json& options) {
  const auto is = [&](const char* option, const char* value) {
    return options.contains(option) && options[option] == value;
  };
  return is("prior", kIntervalsModel) && is("papillary", "cavity");
}

bool is_mostly_told(const std::vector<SliceBelief>& slices) {
  double told_mm2 = 0;
  double all_mm2 = 0;
  for (const SliceBelief& slice : slices) {
    all_mm2 += slice.labelled_mm2;
    if (slice.is_told()) told_mm2 += slice.labelled_mm2;
  }
  return told_mm2 > 0.5 * all_mm2;
}

PredictionIntervals prediction_intervals(const Segmentation& segmentation,
                                         const HeartFigures& figures) {
  PredictionIntervals out;
  if (figures.lv) put_ventricle(segmentation, Structure::LvBlood, *figures.lv, "lv", out);
  if (figures.rv) put_ventricle(segmentation, Structure::RvBlood, *figures.rv, "rv", out);
  if (figures.lv && figures.lv_mass_g) {
    const double ml = *figures.lv_mass_g / kMuscleGPerMl;
    const auto muscle = volume_doubted(segmentation, Structure::LvMyocardium, figures.lv->ed, ml);
    if (muscle) {
      put("lv_mass_g", *figures.lv_mass_g,
          {*figures.lv_mass_g, muscle->more * kMuscleGPerMl, muscle->less * kMuscleGPerMl}, out);
    }
  }
  return out;
}

}  // namespace beatlas::report
