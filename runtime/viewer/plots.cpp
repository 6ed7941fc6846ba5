#include "runtime/viewer/plots.h"

#include <QPolygonF>
#include <QString>
#include <algorithm>
#include <cmath>

#include "runtime/plot/svg.h"

namespace beatlas::viewer {
namespace {

struct Range {
  double low = 0;
  double high = 1;

  [[nodiscard]] double share(double value) const { return (value - low) / (high - low); }
};

Range range_of(const std::vector<Curve>& curves, std::vector<double> Curve::*values,
               bool from_zero) {
  bool any = false;
  Range range;
  for (const Curve& curve : curves) {
    for (const double value : curve.*values) {
      if (!std::isfinite(value)) continue;
      range.low = any ? std::min(range.low, value) : value;
      range.high = any ? std::max(range.high, value) : value;
      any = true;
    }
  }
  if (!any) return {};
  if (from_zero) range.low = std::min(range.low, 0.0);
  const double least = std::max(1e-6, 1e-3 * std::abs(range.high));
  if (range.high - range.low < least) range.high = range.low + std::max(least, 0.1);
  return range;
}

/// Of words and numbers.
QColor ink() { return {225, 228, 232}; }

/// Where a panel's curves are painted, and what its axes span there.
struct Frame {
  QRect area;  ///< [pixels] of the panel, with title and numbers
  QRect box;   ///< [pixels] of the curves alone
  Range x;     ///< in the curves' units, as are y and the steps
  Range y;
  double x_step = 1;  ///< between lines of the grid
  double y_step = 1;

  [[nodiscard]] QPointF at(double px, double py) const {
    return {box.left() + x.share(px) * box.width(), box.bottom() - y.share(py) * box.height()};
  }
};

/// Fits the axes to the curves, with lines at round numbers as many as their figures have room for.
void fit_axes(const QFontMetrics& metrics, const Panel& panel, Frame& frame) {
  frame.x = range_of(panel.curves, &Curve::x, false);
  frame.y = range_of(panel.curves, &Curve::y, panel.from_zero);
  Range& y = frame.y;
  const int rows = std::max(2, frame.box.height() / (2 * metrics.height()));
  frame.y_step = plot::round_step(y.high - y.low, rows);
  y.low = frame.y_step * std::floor(y.low / frame.y_step);
  y.high = frame.y_step * std::ceil(y.high / frame.y_step - 1e-9);
  const int columns = std::max(2, frame.box.width() / metrics.horizontalAdvance("00000"));
  frame.x_step = plot::round_step(frame.x.high - frame.x.low, columns);
}

/// Lines of the grid with their numbers, and the line of now.
void paint_grid(QPainter& painter, const Frame& frame, const std::optional<double>& now) {
  const auto& [area, box, x, y, x_step, y_step] = frame;
  const int line = QFontMetrics(painter.font()).height();
  const QPen grid(QColor(70, 76, 86), 1);
  for (double value = y.low; value <= y.high + 0.01 * y_step; value += y_step) {
    const double level = frame.at(x.low, value).y();
    painter.setPen(grid);
    painter.drawLine(QPointF(box.left(), level), QPointF(box.right(), level));
    painter.setPen(ink());
    painter.drawText(QRectF(area.left(), level - line, box.left() - area.left() - 5, 2 * line),
                     Qt::AlignRight | Qt::AlignVCenter,
                     QString::number(std::abs(value) < 1e-9 * y_step ? 0 : value, 'g', 4));
  }
  for (double value = x_step * std::ceil(x.low / x_step - 1e-9); value <= x.high + 0.01 * x_step;
       value += x_step) {
    const double column = frame.at(value, y.low).x();
    painter.setPen(grid);
    painter.drawLine(QPointF(column, box.top()), QPointF(column, box.bottom()));
    painter.setPen(ink());
    painter.drawText(QRectF(column - 50, box.bottom() + 2, 100, line), Qt::AlignHCenter,
                     QString::number(std::abs(value) < 1e-9 * x_step ? 0 : value, 'g', 4));
  }
  if (now) {
    const double column = frame.at(std::clamp(*now, x.low, x.high), y.low).x();
    painter.setPen(QPen(ink(), 1, Qt::DashLine));
    painter.drawLine(QPointF(column, box.top()), QPointF(column, box.bottom()));
  }
}

void paint_curves(QPainter& painter, const Frame& frame, const std::vector<Curve>& curves) {
  for (const Curve& curve : curves) {
    QPolygonF points;
    const std::size_t count = std::min(curve.x.size(), curve.y.size());
    for (std::size_t n = 0; n < count; ++n) {
      if (std::isfinite(curve.x[n]) && std::isfinite(curve.y[n])) {
        points << frame.at(curve.x[n], curve.y[n]);
      }
    }
    painter.setPen(QPen(curve.colour, 1.8));
    painter.drawPolyline(points);
  }
}

/// Curves' names beside the title, or where that is too narrow below each other in the box.
/// @param title_end where the title and a gap behind it end [pixels]
void paint_names(QPainter& painter, const Frame& frame, const std::vector<Curve>& curves,
                 int title_end) {
  const QFontMetrics metrics(painter.font());
  const int line = metrics.height();
  const QRect& box = frame.box;
  int names_width = 0;
  for (const Curve& curve : curves) {
    names_width += metrics.horizontalAdvance(QString::fromStdString(curve.name)) + 12;
  }
  const bool beside = box.right() - names_width > title_end;
  int name_x = box.right();
  int name_y = box.bottom() - line / 2 - line * (static_cast<int>(curves.size()) - 1);
  for (const Curve& curve : curves) {
    if (curve.name.empty()) continue;
    const QString name = QString::fromStdString(curve.name);
    painter.setPen(curve.colour);
    const int width = metrics.horizontalAdvance(name);
    if (beside) {
      name_x -= width + 12;
      painter.drawText(name_x, frame.area.top() + line, name);
    } else {
      painter.drawText(box.center().x() - width / 2, name_y, name);
      name_y += line;
    }
  }
}

void paint_panel(QPainter& painter, const QRect& area, const Panel& panel) {
  const QFontMetrics metrics(painter.font());
  const int line = metrics.height();
  Frame frame;
  frame.area = area;
  frame.box =
      area.adjusted(metrics.horizontalAdvance("-0000 "), line + line / 2 + 8, -12, -2 * line - 4);
  const QRect& box = frame.box;
  if (box.width() < 20 || box.height() < 20) return;
  painter.setPen(ink());
  QString title = QString::fromStdString(panel.title);
  if (panel.curves.size() == 1 && !panel.curves.front().y.empty()) {
    title += QString("   %1").arg(panel.curves.front().y.back(), 0, 'f', 2);
  }
  painter.drawText(area.left() + 8, area.top() + line, title);

  fit_axes(metrics, panel, frame);
  paint_grid(painter, frame, panel.now);
  painter.setPen(ink());
  painter.drawText(QRectF(box.left(), box.bottom() + line, box.width(), line + 2), Qt::AlignHCenter,
                   QString::fromStdString(panel.x_title));
  paint_curves(painter, frame, panel.curves);
  paint_names(painter, frame, panel.curves,
              area.left() + 8 + metrics.horizontalAdvance(title) + 12);
}

}  // namespace

void paint_panels(QPainter& painter, const QRect& area, const std::vector<Panel>& panels) {
  painter.setRenderHint(QPainter::Antialiasing);
  painter.fillRect(area, QColor(24, 27, 33));
  const int count = static_cast<int>(panels.size());
  for (int n = 0; n < count; ++n) {
    const int top = area.top() + area.height() * n / count;
    const int bottom = area.top() + area.height() * (n + 1) / count;
    paint_panel(painter, QRect(area.left(), top, area.width(), bottom - top),
                panels[static_cast<std::size_t>(n)]);
  }
}

}  // namespace beatlas::viewer
