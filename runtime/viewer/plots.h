#pragma once
/// Small line plots beside the picture. Within this room alone: here are Qt's types.

#include <QImage>
#include <QPainter>
#include <QRect>
#include <optional>
#include <string>
#include <vector>

namespace beatlas::viewer {

struct Curve {
  std::string name;  ///< in the legend; empty: none
  QColor colour;
  std::vector<double> x;
  std::vector<double> y;
};

/// One member of the rows against another.
template <class Row>
[[nodiscard]] Curve curve(const std::vector<Row>& rows, double Row::*x, double Row::*y,
                          const std::string& name, const QColor& colour) {
  Curve made{.name = name, .colour = colour, .x = {}, .y = {}};
  for (const Row& row : rows) {
    made.x.push_back(row.*x);
    made.y.push_back(row.*y);
  }
  return made;
}

struct Panel {
  std::string title;    ///< with unit
  std::string x_title;  ///< with unit
  std::vector<Curve> curves;
  bool from_zero = false;
  std::optional<double> now = std::nullopt;  ///< a line at this x
};

/// Panels below each other, on a dark ground; axes with round numbers, the last value in the title
/// where there is one curve.
void paint_panels(QPainter& painter, const QRect& area, const std::vector<Panel>& panels);

}  // namespace beatlas::viewer
