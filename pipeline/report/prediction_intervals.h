#pragma once
/// Between which values a figure lies most likely.

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/shapes.h"
#include "pipeline/report/heart_figures.h"

namespace beatlas::report {

/// SHA-256 of the model (an ONNX file) that found the labels that intervals were fitted to, with
/// papillary muscles as cavity: of others they are not known.
inline constexpr auto kIntervalsModel =
    "68a409f6adf0b63d40f3444d7ac4a8c19340c1f0dfcc1c8eef4f90bd63f1cac9";

/// Whether labels grew as those did that intervals, and bands of surfaces, were fitted to.
/// @param options of the stage segment, as a study records them
[[nodiscard]] bool is_fitted_to(const nlohmann::json& options);

/// Whether a person told what more than half of the labelled area is: there is no opinion beside
/// such labels.
[[nodiscard]] bool is_mostly_told(const std::vector<SliceBelief>& slices);

/// In the unit of its figure.
struct PredictionInterval {
  double low = 0;
  double high = 0;
};

/// By the figure's key in report.json.
using PredictionIntervals = std::map<std::string, PredictionInterval>;

/// 90 % prediction intervals of the volumes, ejection fractions and stroke volumes of both
/// ventricles and of the LV's mass: of a twentieth of drawn hearts the true figure lies below, of
/// a twentieth above.
///
/// A figure is below the truth by what is expected and not labelled (`more`), and above it by what
/// is labelled and not expected (`less`), both in the slices that hold labels and the next ones
/// (SliceBelief). So the upper bound is the figure and a s + b more + c less, the lower one the
/// figure less a' s + b' less + c' more. The scale s is the figure itself, of a stroke volume the
/// EDV, of an EF 100 %; of these two `more` is that of end-diastole and the `less` of end-systole
/// together, and the other way round, over the EDV for the EF. The numbers, 0 or more, are found
/// by quantile regression (Koenker and Bassett, Econometrica 1978;46:33-50, doi:10.2307/1913643):
/// `scripts/fit_intervals`.
///
/// A figure has none where no prior was asked, where a person told what more than half of the
/// structure's labelled area is, or where the structure was not found; an EF and a stroke volume
/// want both phases.
[[nodiscard]] PredictionIntervals prediction_intervals(const Segmentation& segmentation,
                                                       const HeartFigures& figures);

}  // namespace beatlas::report
