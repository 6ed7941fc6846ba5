#include "runtime/plot/plot.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "runtime/base/error.h"
#include "runtime/plot/svg.h"

namespace beatlas::plot {
namespace {

constexpr double kWidth = 820;
constexpr double kPanel = 320;
constexpr double kLeft = 74, kRight = 216, kTop = 34, kBottom = 46;
constexpr double kAcross = kWidth - kLeft - kRight;  // of the field that shows values
constexpr double kUp = kPanel - kTop - kBottom;

class Axis {
 public:
  explicit Axis(bool logarithmic) : log_(logarithmic) {}

  [[nodiscard]] bool shows(double value) const {
    return std::isfinite(value) && (!log_ || value > 0);
  }
  void take(double value) {
    low_ = std::min(low_, at(value));
    high_ = std::max(high_, at(value));
  }
  void take_zero() { low_ = log_ ? low_ : std::min(low_, 0.0); }

  // Room to both ends, and marks.
  void finish(int most) {
    if (log_) {
      low_ = std::floor(low_ + 1e-9);
      high_ = std::max(std::ceil(high_ - 1e-9), low_ + 1);
      const int step = std::max(1, static_cast<int>(std::ceil((high_ - low_) / most)));
      for (double power = low_; power <= high_; power += step)
        marks_.push_back(std::pow(10, power));
      return;
    }
    if (!(high_ > low_)) {
      const double half = std::max(0.5 * std::abs(low_), 0.5);
      low_ -= half;
      high_ += half;
    }
    const double step = round_step(high_ - low_, most);
    low_ = step * std::floor(low_ / step + 1e-9);
    high_ = step * std::ceil(high_ / step - 1e-9);
    for (int n = 0; low_ + n * step <= high_ + 1e-9 * step; ++n) {
      const double mark = step * std::round((low_ + n * step) / step);
      marks_.push_back(mark == 0 ? 0 : mark);
    }
  }
  [[nodiscard]] double share(double value) const { return (at(value) - low_) / (high_ - low_); }
  [[nodiscard]] const std::vector<double>& marks() const { return marks_; }

 private:
  [[nodiscard]] double at(double value) const { return log_ ? std::log10(value) : value; }

  bool log_;
  double low_ = INFINITY;
  double high_ = -INFINITY;
  std::vector<double> marks_;
};

using Points = std::vector<std::array<double, 2>>;

// Of many points in one column of pixels the first, lowest, highest and last, in their order.
Points thinned(const Points& points) {
  constexpr std::size_t kFew = 2000;
  if (points.size() <= kFew) return points;
  Points out;
  for (std::size_t begin = 0; begin < points.size();) {
    std::size_t end = begin + 1;
    std::size_t least = begin;
    std::size_t most = begin;
    const double column = std::floor(2 * points[begin][0]);
    for (; end < points.size() && std::floor(2 * points[end][0]) == column; ++end) {
      if (points[end][1] < points[least][1]) least = end;
      if (points[end][1] > points[most][1]) most = end;
    }
    std::array<std::size_t, 4> keep{begin, least, most, end - 1};
    std::sort(keep.begin(), keep.end());
    for (std::size_t n = 0; n < keep.size(); ++n) {
      if (n == 0 || keep[n] != keep[n - 1]) out.push_back(points[keep[n]]);
    }
    begin = end;
  }
  return out;
}

// Where a panel's values come to lie [pixels].
class PanelFrame {
 public:
  PanelFrame(const Plot& plot, double top) : top_(top), across_(plot.log_x), up_(plot.log_y) {
    std::size_t shown = 0;
    for (const PlotSeries& series : plot.series) {
      for (std::size_t n = 0; n < std::min(series.x.size(), series.y.size()); ++n) {
        if (!across_.shows(series.x[n]) || !up_.shows(series.y[n])) continue;
        across_.take(series.x[n]);
        up_.take(series.y[n]);
        ++shown;
      }
    }
    if (shown == 0) throw_invalid("there is nothing to plot in \"" + plot.title + "\"");
    if (plot.from_zero) up_.take_zero();
    across_.finish(9);
    up_.finish(6);
  }

  [[nodiscard]] double x(double value) const { return kLeft + kAcross * across_.share(value); }
  [[nodiscard]] double y(double value) const { return top_ + kTop + kUp * (1 - up_.share(value)); }
  // Of a series what can be shown.
  [[nodiscard]] Points points(const PlotSeries& series) const {
    Points out;
    for (std::size_t n = 0; n < std::min(series.x.size(), series.y.size()); ++n) {
      if (!across_.shows(series.x[n]) || !up_.shows(series.y[n])) continue;
      out.push_back({x(series.x[n]), y(series.y[n])});
    }
    return out;
  }
  // Lines at the marks of both axes, and what they stand for.
  [[nodiscard]] std::string marks_svg() const {
    std::string svg;
    for (const double mark : up_.marks()) {
      svg += line(kLeft, y(mark), kLeft + kAcross, y(mark), "stroke=\"#dddddd\"");
      svg += text_at(kLeft - 6, y(mark) + 4, "end", shortest(mark));
    }
    for (const double mark : across_.marks()) {
      svg += line(x(mark), top_ + kTop, x(mark), top_ + kTop + kUp, "stroke=\"#dddddd\"");
      svg += text_at(x(mark), top_ + kTop + kUp + 16, "middle", shortest(mark));
    }
    return svg;
  }

 private:
  double top_;
  Axis across_;
  Axis up_;
};

std::string titles_svg(const Plot& plot, double top) {
  std::string svg =
      text_at(kLeft, top + 18, "start", plot.title, " font-size=\"14\" font-weight=\"bold\"");
  svg += text_at(kLeft + kAcross / 2, top + kPanel - 10, "middle", plot.x_title);
  const double middle = top + kTop + kUp / 2;
  svg += text_at(16, middle, "middle", plot.y_title,
                 " transform=\"rotate(-90 16 " + pixels(middle) + ")\"");
  return svg;
}

std::string curve_svg(const Points& points, bool dots, const std::string& colour,
                      const std::string& style) {
  std::string svg = "<polyline " + style + " points=\"";
  for (const auto& point : points) svg += pixels(point[0]) + "," + pixels(point[1]) + " ";
  svg += "\"/>\n";
  if (!dots) return svg;
  for (const auto& point : points) {
    svg += "<circle cx=\"" + pixels(point[0]) + "\" cy=\"" + pixels(point[1]) +
           "\" r=\"3\" fill=\"" + colour + "\"/>\n";
  }
  return svg;
}

std::string panel_svg(const Plot& plot, double top) {
  if (plot.series.size() > kColours.size()) throw_invalid("a plot has up to 8 series");
  const PanelFrame frame(plot, top);
  std::string svg = frame.marks_svg() + titles_svg(plot, top);
  double legend = top + kTop + 12;
  for (std::size_t s = 0; s < plot.series.size(); ++s) {
    const PlotSeries& series = plot.series[s];
    const std::string colour = kColours[s];
    const std::string style = "stroke=\"" + colour + "\" stroke-width=\"1.8\" fill=\"none\"" +
                              (series.dashed ? " stroke-dasharray=\"6 4\"" : "");
    svg += curve_svg(thinned(frame.points(series)), series.dots, colour, style);
    if (series.name.empty()) continue;
    svg += line(kLeft + kAcross + 12, legend - 4, kLeft + kAcross + 32, legend - 4, style);
    svg += text_at(kLeft + kAcross + 38, legend, "start", series.name);
    legend += 18;
  }
  return svg;
}

}  // namespace

std::string plots_svg(const std::vector<Plot>& panels) {
  if (panels.empty()) throw_invalid("there is nothing to plot");
  const double height = kPanel * static_cast<double>(panels.size());
  std::string svg = svg_head(kWidth, height);
  for (std::size_t n = 0; n < panels.size(); ++n) {
    svg += panel_svg(panels[n], kPanel * static_cast<double>(n));
  }
  return svg + "</svg>\n";
}

}  // namespace beatlas::plot
