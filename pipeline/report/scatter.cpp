#include "pipeline/report/scatter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "runtime/base/error.h"
#include "runtime/plot/svg.h"

namespace beatlas::report {
namespace {

using plot::kColours;
using plot::line;
using plot::pixels;
using plot::shortest;
using plot::svg_head;
using plot::text_at;

constexpr double kWidth = 820, kHeight = 520;
constexpr double kLeft = 74, kRight = 196, kTop = 44, kBottom = 56;
constexpr double kText = 12, kMarker = 4.5, kRing = 8;
struct Box {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  [[nodiscard]] bool overlaps(const Box& b) const {
    return x0 < b.x1 && b.x0 < x1 && y0 < b.y1 && b.y0 < y1;
  }
};

struct Spot {
  double x = 0, y = 0;
};

/// A logarithmic axis over whole or 1-2-5 decades.
class Axis {
 public:
  Axis(double low, double high, double from, double to) : from_(from), to_(to) {
    const double pad = std::pow(high / low, 0.06) * 1.05;
    low_ = std::log10(low / pad);
    high_ = std::log10(high * pad);
  }
  [[nodiscard]] double at(double value) const {
    return from_ + (to_ - from_) * (std::log10(value) - low_) / (high_ - low_);
  }
  struct Tick {
    double value = 0;
    bool labelled = false;
  };
  [[nodiscard]] std::vector<Tick> ticks() const {
    const double decades = high_ - low_;
    std::vector<Tick> out;
    for (int e = static_cast<int>(std::floor(low_)); e <= static_cast<int>(std::ceil(high_)); ++e) {
      for (int factor = 1; factor < 10; ++factor) {
        const double value = factor * std::pow(10.0, e);
        if (std::log10(value) < low_ || std::log10(value) > high_) continue;
        const bool labelled = factor == 1 || (decades < 2.6 && (factor == 2 || factor == 5)) ||
                              (decades < 0.8 && (factor == 3 || factor == 4 || factor == 7)) ||
                              (decades < 0.4 && factor != 9);
        out.push_back({value, labelled});
      }
    }
    return out;
  }

 private:
  double low_ = 0, high_ = 1;
  double from_, to_;
};

std::string marker(std::size_t kind, Spot at, const char* colour) {
  const double r = kMarker;
  const std::string fill = std::string("fill=\"") + colour + "\" stroke=\"white\"";
  const auto polygon = [&](const std::vector<Spot>& corners) {
    std::string out = "<polygon " + fill + " points=\"";
    for (const Spot& c : corners) out += pixels(at.x + c.x) + "," + pixels(at.y + c.y) + " ";
    return out + "\"/>\n";
  };
  switch (kind % 4) {
    case 0:
      return "<circle cx=\"" + pixels(at.x) + "\" cy=\"" + pixels(at.y) + "\" r=\"" + pixels(r) +
             "\" " + fill + "/>\n";
    case 1:
      return polygon({{-r, -r}, {r, -r}, {r, r}, {-r, r}});
    case 2:
      return polygon({{0, -1.3 * r}, {1.2 * r, r}, {-1.2 * r, r}});
    default:
      return polygon({{0, -1.4 * r}, {1.4 * r, 0}, {0, 1.4 * r}, {-1.4 * r, 0}});
  }
}

bool drawable(const ScatterPoint& point) {
  return point.x > 0 && point.y > 0 && std::isfinite(point.x) && std::isfinite(point.y);
}

struct Drawn {
  ScatterPoint point;
  Spot at;
  std::size_t series = 0;
};

/// Places labels one after the other where they overlap nothing.
class Labels {
 public:
  explicit Labels(const std::vector<Drawn>& drawn) {
    for (const Drawn& each : drawn) {
      const double around = (each.point.emphasised ? kRing : kMarker) + 1.5;
      taken_.push_back(
          {each.at.x - around, each.at.y - around, each.at.x + around, each.at.y + around});
    }
  }

  std::string place(const Drawn& drawn) {
    const double letter = (drawn.point.emphasised ? 0.64 : 0.57) * kText;
    const double width = letter * static_cast<double>(drawn.point.label.size()) + 2;
    const double gap = drawn.point.emphasised ? kRing + 3 : kMarker + 3;
    struct Try {
      double dx, dy;
      const char* anchor;
    };
    const std::array<Try, 8> tries{{{gap, 4, "start"},
                                    {-gap, 4, "end"},
                                    {0, -gap - 2, "middle"},
                                    {0, gap + 10, "middle"},
                                    {gap - 2, -gap, "start"},
                                    {-gap + 2, -gap, "end"},
                                    {gap - 2, gap + 8, "start"},
                                    {-gap + 2, gap + 8, "end"}}};
    for (const Try& each : tries) {
      const double x = drawn.at.x + each.dx;
      const double y = drawn.at.y + each.dy;
      const double x0 = each.anchor[0] == 's'   ? x
                        : each.anchor[0] == 'e' ? x - width
                                                : x - width / 2;
      const Box box{x0, y - 0.8 * kText, x0 + width, y + 0.25 * kText};
      if (box.x0 < kLeft + 2 || box.x1 > kWidth - kRight - 2 || box.y0 < kTop + 2 ||
          box.y1 > kHeight - kBottom - 2) {
        continue;
      }
      if (std::any_of(taken_.begin(), taken_.end(),
                      [&](const Box& other) { return box.overlaps(other); })) {
        continue;
      }
      taken_.push_back(box);
      // A white rim keeps lines behind the words from striking them through.
      const std::string rim =
          " paint-order=\"stroke\" stroke=\"white\" stroke-width=\"3\" stroke-linejoin=\"round\"";
      return text_at(x, y, each.anchor, drawn.point.label,
                     drawn.point.emphasised ? rim + " font-weight=\"bold\"" : rim);
    }
    return "";
  }

 private:
  std::vector<Box> taken_;
};

/// The staircase through the points of the front: what no point undercuts.
std::string front_line(std::vector<Drawn> drawn, double right, double top) {
  std::erase_if(drawn, [](const Drawn& each) { return !each.point.on_front; });
  if (drawn.empty()) return "";
  std::sort(drawn.begin(), drawn.end(), [](const Drawn& a, const Drawn& b) {
    return a.at.x != b.at.x ? a.at.x < b.at.x : a.at.y > b.at.y;
  });
  std::string points = pixels(drawn.front().at.x) + "," + pixels(top) + " ";
  for (std::size_t n = 0; n < drawn.size(); ++n) {
    if (n > 0) points += pixels(drawn[n].at.x) + "," + pixels(drawn[n - 1].at.y) + " ";
    points += pixels(drawn[n].at.x) + "," + pixels(drawn[n].at.y) + " ";
  }
  points += pixels(right) + "," + pixels(drawn.back().at.y);
  return "<polyline fill=\"none\" stroke=\"#9a9a9a\" stroke-width=\"1.5\" "
         "stroke-dasharray=\"5 3\" points=\"" +
         points + "\"/>\n";
}

struct Axes {
  Axis x;
  Axis y;
};

/// Axes that hold all points. @throws Error{InvalidInput} if there is none
Axes axes_of(const ScatterPlot& plot) {
  double x_low = 0, x_high = 0, y_low = 0, y_high = 0;
  bool any = false;
  for (const ScatterSeries& series : plot.series) {
    for (const ScatterPoint& point : series.points) {
      if (!drawable(point)) continue;
      x_low = any ? std::min(x_low, point.x) : point.x;
      x_high = any ? std::max(x_high, point.x) : point.x;
      y_low = any ? std::min(y_low, point.y) : point.y;
      y_high = any ? std::max(y_high, point.y) : point.y;
      any = true;
    }
  }
  if (!any) throw_invalid("there is no point to plot");
  return {Axis(x_low, x_high, kLeft, kWidth - kRight),
          Axis(y_low, y_high, kHeight - kBottom, kTop)};
}

std::vector<Drawn> points_on(const Axes& axes, const ScatterPlot& plot) {
  std::vector<Drawn> drawn;
  for (std::size_t s = 0; s < plot.series.size(); ++s) {
    for (const ScatterPoint& point : plot.series[s].points) {
      if (drawable(point)) drawn.push_back({point, {axes.x.at(point.x), axes.y.at(point.y)}, s});
    }
  }
  return drawn;
}

/// Lines of the ticks, and what is written beside them.
std::string grid_svg(const Axes& axes, const ScatterPlot& plot) {
  const double right = kWidth - kRight;
  const double bottom = kHeight - kBottom;
  std::string svg;
  for (const Axis::Tick& tick : axes.x.ticks()) {
    const double x = axes.x.at(tick.value);
    svg += line(x, kTop, x, bottom, tick.labelled ? "stroke=\"#dddddd\"" : "stroke=\"#f2f2f2\"");
    if (tick.labelled) svg += text_at(x, bottom + 17, "middle", shortest(tick.value));
  }
  for (const Axis::Tick& tick : axes.y.ticks()) {
    const double y = axes.y.at(tick.value);
    svg += line(kLeft, y, right, y, tick.labelled ? "stroke=\"#dddddd\"" : "stroke=\"#f2f2f2\"");
    if (tick.labelled) svg += text_at(kLeft - 7, y + 4, "end", shortest(tick.value));
  }
  svg += line(kLeft, bottom, right, bottom, "stroke=\"#444444\"");
  svg += line(kLeft, kTop, kLeft, bottom, "stroke=\"#444444\"");
  svg += text_at((kLeft + right) / 2, kHeight - 14, "middle", plot.x_title);
  svg += text_at(0, 0, "middle", plot.y_title,
                 " transform=\"translate(18 " + pixels((kTop + bottom) / 2) + ") rotate(-90)\"");
  return svg;
}

/// Lines from point to point of the series that are joined.
std::string joining_lines(const std::vector<Drawn>& drawn, const ScatterPlot& plot) {
  std::string svg;
  for (std::size_t s = 0; s < plot.series.size(); ++s) {
    if (!plot.series[s].joined) continue;
    svg +=
        std::string("<polyline fill=\"none\" stroke-width=\"1\" stroke-opacity=\"0.6\" stroke=\"") +
        kColours[s] + "\" points=\"";
    for (const Drawn& each : drawn) {
      if (each.series == s) svg += pixels(each.at.x) + "," + pixels(each.at.y) + " ";
    }
    svg += "\"/>\n";
  }
  return svg;
}

std::string markers_svg(const std::vector<Drawn>& drawn) {
  std::string svg;
  for (const Drawn& each : drawn) svg += marker(each.series, each.at, kColours[each.series]);
  for (const Drawn& each : drawn) {
    if (!each.point.emphasised) continue;
    svg += "<circle cx=\"" + pixels(each.at.x) + "\" cy=\"" + pixels(each.at.y) + "\" r=\"" +
           pixels(kRing) + "\" fill=\"none\" stroke=\"black\" stroke-width=\"1.4\"/>\n";
  }
  return svg;
}

/// Points' names as far as there is room: of emphasised points first, then of those of the front.
std::string labels_svg(const std::vector<Drawn>& drawn) {
  std::string svg;
  Labels labels(drawn);
  const auto label_all = [&](auto&& wanted) {
    for (const Drawn& each : drawn) {
      if (!each.point.label.empty() && wanted(each.point)) svg += labels.place(each);
    }
  };
  label_all([](const ScatterPoint& p) { return p.emphasised; });
  label_all([](const ScatterPoint& p) { return !p.emphasised && p.on_front; });
  label_all([](const ScatterPoint& p) { return !p.emphasised && !p.on_front; });
  return svg;
}

/// What markers and lines stand for, right of the plot.
std::string legend_svg(const std::vector<Drawn>& drawn, const ScatterPlot& plot) {
  std::string svg;
  double y = kTop + 10;
  const double x = kWidth - kRight + 16;
  for (std::size_t s = 0; s < plot.series.size(); ++s) {
    svg += marker(s, {x + 6, y - 4}, kColours[s]);
    svg += text_at(x + 20, y, "start", plot.series[s].name);
    y += 19;
  }
  if (!plot.front_name.empty()) {
    svg += line(x - 2, y - 4, x + 14, y - 4,
                "stroke=\"#9a9a9a\" stroke-width=\"1.5\" stroke-dasharray=\"5 3\"");
    svg += text_at(x + 20, y, "start", plot.front_name);
    y += 19;
  }
  if (std::any_of(drawn.begin(), drawn.end(), [](const Drawn& d) { return d.point.emphasised; })) {
    svg += "<circle cx=\"" + pixels(x + 6) + "\" cy=\"" + pixels(y - 4) +
           "\" r=\"7\" fill=\"none\" stroke=\"black\" stroke-width=\"1.4\"/>\n";
    svg += text_at(x + 20, y, "start", "default");
  }
  return svg;
}

}  // namespace

std::string scatter_svg(const ScatterPlot& plot) {
  if (plot.series.size() > kColours.size()) throw_invalid("a plot has room for eight series");
  const Axes axes = axes_of(plot);
  const std::vector<Drawn> drawn = points_on(axes, plot);
  std::string svg = svg_head(kWidth, kHeight);
  svg += text_at(kLeft, 24, "start", plot.title, " font-size=\"15\" font-weight=\"bold\"");
  svg += grid_svg(axes, plot);
  if (!plot.front_name.empty()) svg += front_line(drawn, kWidth - kRight, kTop);
  svg += joining_lines(drawn, plot);
  svg += markers_svg(drawn);
  svg += labels_svg(drawn);
  svg += legend_svg(drawn, plot);
  return svg + "</svg>\n";
}

}  // namespace beatlas::report
