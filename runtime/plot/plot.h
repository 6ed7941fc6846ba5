#pragma once
#include <string>
#include <vector>

namespace beatlas::plot {

struct PlotSeries {
  std::string name;  ///< in the legend; empty: none
  std::vector<double> x;
  std::vector<double> y;
  bool dots = false;  ///< a dot at every point, too
  bool dashed = false;
};

/// One panel; panels of a figure lie below each other.
struct Plot {
  std::string title;
  std::string x_title;
  std::string y_title;
  std::vector<PlotSeries> series;  ///< 1..8
  bool log_x = false;              ///< points that are not positive are left out
  bool log_y = false;
  bool from_zero = false;  ///< the y axis begins at 0
};

/// A self-contained SVG, 820 wide, white background, the colours of Okabe and Ito. Lines are
/// thinned to what a pixel shows. The same plots give the same bytes.
/// @throws Error{InvalidInput} if a panel has no point that can be drawn, or more than 8 series.
[[nodiscard]] std::string plots_svg(const std::vector<Plot>& panels);

}  // namespace beatlas::plot
