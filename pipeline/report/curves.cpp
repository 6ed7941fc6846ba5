#include "pipeline/report/curves.h"

#include <algorithm>
#include <cmath>

#include "runtime/atlas/structure_colours.h"
#include "runtime/base/error.h"
#include "runtime/plot/svg.h"

namespace beatlas::report {
namespace {

using plot::line;
using plot::pixels;
using plot::round_step;
using plot::shortest;
using plot::svg_head;
using plot::text_at;

constexpr double kWidth = 760, kHeight = 440;
constexpr double kLeft = 64, kRight = 150, kTop = 24, kBottom = 52;

}  // namespace

std::string volume_curves_svg(const std::vector<VolumeCurve>& curves, double rr_interval_s,
                              int end_diastole, int end_systole) {
  if (curves.empty() || curves.front().volume_ml.empty() || !(rr_interval_s > 0)) {
    throw_invalid("there is no volume curve to draw");
  }
  const std::size_t phases = curves.front().volume_ml.size();
  double top_ml = 0;
  for (const VolumeCurve& curve : curves) {
    if (curve.volume_ml.size() != phases) throw_invalid("volume curves differ in their phases");
    for (double volume : curve.volume_ml) top_ml = std::max(top_ml, volume);
  }
  if (!(top_ml > 0) || !std::isfinite(top_ml)) top_ml = 1;
  const double step_ml = round_step(1.05 * top_ml, 6);
  top_ml = step_ml * std::ceil(1.02 * top_ml / step_ml);

  const double width = kWidth - kLeft - kRight;
  const double height = kHeight - kTop - kBottom;
  const auto x_of = [&](double t_s) { return kLeft + width * t_s / rr_interval_s; };
  const auto y_of = [&](double ml) { return kTop + height * (1 - ml / top_ml); };
  const auto time_of = [&](std::size_t p) {
    return rr_interval_s * static_cast<double>(p) / static_cast<double>(phases);
  };

  std::string svg = svg_head(kWidth, kHeight);
  const std::string rule = "stroke=\"#dddddd\"";
  for (int i = 0; i * step_ml <= top_ml * 1.0001; ++i) {
    const double ml = i * step_ml;
    svg += line(kLeft, y_of(ml), kLeft + width, y_of(ml), rule);
    svg += text_at(kLeft - 6, y_of(ml) + 4, "end", shortest(ml));
  }
  const double step_s = round_step(rr_interval_s, 8);
  for (int i = 0; i * step_s <= rr_interval_s * 1.0001; ++i) {
    svg += line(x_of(i * step_s), kTop, x_of(i * step_s), kTop + height, rule);
    svg += text_at(x_of(i * step_s), kTop + height + 16, "middle", shortest(i * step_s));
  }
  svg += text_at(kLeft + width / 2, kHeight - 12, "middle", "time in the R-R interval [s]");
  svg += text_at(kLeft, kTop - 8, "middle", "volume [ml]");
  const auto mark = [&](int phase, const std::string& name) {
    if (phase < 0 || static_cast<std::size_t>(phase) >= phases) return;
    const double x = x_of(time_of(static_cast<std::size_t>(phase)));
    svg += line(x, kTop, x, kTop + height, "stroke=\"#888888\" stroke-dasharray=\"4 3\"");
    svg += text_at(x + 3, kTop + 12, "start", name);
  };
  mark(end_diastole, "ED");
  mark(end_systole, "ES");

  double legend_y = kTop + 12;
  for (const VolumeCurve& curve : curves) {
    const std::string style = "stroke=\"" + colour_code(structure_ink(curve.structure)) +
                              "\" stroke-width=\"2\" fill=\"none\"";
    svg += "<polyline " + style + " points=\"";
    for (std::size_t p = 0; p <= phases; ++p) {
      svg += pixels(x_of(time_of(p))) + "," + pixels(y_of(curve.volume_ml[p % phases])) + " ";
    }
    svg += "\"/>\n";
    svg += line(kLeft + width + 14, legend_y - 4, kLeft + width + 34, legend_y - 4, style);
    svg += text_at(kLeft + width + 40, legend_y, "start",
                   std::string(structure_name(curve.structure)));
    legend_y += 18;
  }
  return svg + "</svg>\n";
}

}  // namespace beatlas::report
