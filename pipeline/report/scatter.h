#pragma once
#include <string>
#include <vector>

namespace beatlas::report {

struct ScatterPoint {
  double x = 0;
  double y = 0;
  std::string label;        ///< written beside the point where there is room
  bool emphasised = false;  ///< a ring around it, and its label first
  bool on_front = false;    ///< joined by the front's staircase
};

struct ScatterSeries {
  std::string name;  ///< in the legend
  std::vector<ScatterPoint> points;
  bool joined = false;  ///< a thin line through the points in their order
};

struct ScatterPlot {
  std::string title;
  std::string x_title;
  std::string y_title;
  std::vector<ScatterSeries> series;  ///< 1..8: as many colours tell apart, each with a marker too
  std::string front_name;             ///< in the legend; empty: no front
};

/// A self-contained SVG of 820 x 520, both axes logarithmic with labelled ticks, white background,
/// the colours of Okabe and Ito, which the colour-blind tell apart. Points that are not positive
/// and finite are left out. Labels never overlap one another or a point: one without room is left
/// out. The same plot gives the same bytes.
/// @throws Error{InvalidInput} if no point is left or there are too many series.
[[nodiscard]] std::string scatter_svg(const ScatterPlot& plot);

}  // namespace beatlas::report
