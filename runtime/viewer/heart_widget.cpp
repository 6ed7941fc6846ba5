#include "runtime/viewer/heart_widget.h"

#include <QMouseEvent>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <QVTKInteractor.h>
#include <vtkGenericOpenGLRenderWindow.h>

#include "runtime/app/touch.h"
#include "runtime/viewer/drawing_parts.h"

namespace beatlas::viewer {
namespace {

constexpr double kTurnPerPixel = 0.008;  // rad
constexpr double kPushMmPerNotch = 1;
constexpr double kUsualDotsPerInch = 96;
constexpr double kSlowMs = 400;  // a picture that takes longer holds up the mouse

}  // namespace

HeartWidget::HeartWidget(QWidget* parent) : QVTKOpenGLNativeWidget(parent) {
  setEnableHiDPI(true);
  setMinimumSize(64, 48);
  setFocusPolicy(Qt::StrongFocus);
}

HeartWidget::~HeartWidget() {
  makeCurrent();
  drawing_.reset();
}

void HeartWidget::show_heart(const OpenedHeart& heart, bool anaglyph, double text_scale) {
  auto drawing = std::make_unique<HeartDrawing>(
      heart.atlas, heart.field,
      DrawingOptions{.offscreen = false,
                     .anaglyph = anaglyph,
                     .text_scale = text_scale,
                     .display_scale = devicePixelRatioF() * logicalDpiY() / kUsualDotsPerInch});
  const vtkNew<vtkGenericOpenGLRenderWindow> window;
  setRenderWindow(window.Get());
  // The mouse is ours.
  if (interactor() != nullptr) interactor()->SetInteractorStyle(nullptr);
  drawing->parts_->make_window(window.Get());
  drawing_ = std::move(drawing);
  field_ = heart.touched;
  inside_ = !heart.inside.empty() && heart.inside != app::kPericardium;
  drag_ = Drag::None;
}

bool HeartWidget::draw() {
  if (!drawing_ || !isValid() || width() < 1 || height() < 1 || !drawing_->changed()) return false;
  const bool coarse = drag_ != Drag::None && drag_ != Drag::Tool;
  drawing_->set_moving(coarse || (beating_ && slow_));
  drawing_->render();
  const DrawTimes times = drawing_->times();
  if (!coarse && !slow_) slow_ = times.update_ms + times.render_ms > kSlowMs;
  return true;
}

void HeartWidget::set_beating(bool beating) {
  beating_ = beating;
  if (!beating) slow_ = false;
  // At rest the fine picture follows the coarse one.
  if (drawing_ && drag_ == Drag::None && !beating) drawing_->set_moving(false);
}

void HeartWidget::set_tool(const Vec3& position_mm, double radius_mm) {
  tool_radius_mm_ = radius_mm;
  if (drag_ != Drag::Tool && drawing_) tool_depth_mm_ = drawing_->depth_of(position_mm);
}

Vec2 HeartWidget::pixel(const QPointF& at) const {
  const double ratio = devicePixelRatioF();
  return {ratio * at.x(), ratio * at.y()};
}

// Depth along the line of sight at which the tool would just touch; in a cavity the middle of the
// blood that the line goes through. The heart's middle where the line passes by.
double HeartWidget::depth_under(const Vec2& at) const {
  const double middle = drawing_->depth_of(drawing_->frame().centre_mm);
  if (!field_) return middle;
  constexpr double kReachMm = 250;
  if (inside_) {
    double least_mm = -tool_radius_mm_;
    double deepest = drawing_->depth_of(field_->centre_mm());
    for (double depth = middle - kReachMm; depth < middle + kReachMm; depth += 0.5) {
      const double mm = field_->sample(drawing_->point_at(at, depth), field_time_s_).distance_mm;
      if (mm < least_mm) std::tie(least_mm, deepest) = std::pair(mm, depth);
    }
    return deepest;
  }
  for (double depth = middle - kReachMm; depth < middle + kReachMm; depth += 0.5) {
    const Vec3 place = drawing_->point_at(at, depth);
    if (field_->sample(place, field_time_s_).distance_mm < tool_radius_mm_) return depth;
  }
  return middle;
}

void HeartWidget::move_tool(const Vec2& at) {
  tool_pixel_ = at;
  if (on_tool) on_tool(drawing_->point_at(at, tool_depth_mm_));
}

void HeartWidget::mousePressEvent(QMouseEvent* event) {
  if (!drawing_) return;
  last_ = event->localPos();
  const bool touches = touching_ != event->modifiers().testFlag(Qt::ControlModifier);
  if (event->button() == Qt::LeftButton && touches) {
    drag_ = Drag::Tool;
    // It comes to the surface from the viewer's side, not through the heart.
    tool_pixel_ = pixel(last_);
    tool_depth_mm_ = depth_under(tool_pixel_);
    if (on_tool_put) on_tool_put(drawing_->point_at(tool_pixel_, tool_depth_mm_));
  } else if (event->button() == Qt::LeftButton && !event->modifiers().testFlag(Qt::ShiftModifier)) {
    drag_ = Drag::Turn;
  } else if (event->button() == Qt::RightButton) {
    drag_ = Drag::Zoom;
  } else {
    drag_ = Drag::Pan;
  }
  if (drag_ != Drag::Tool) drawing_->set_moving(true);
}

void HeartWidget::mouseMoveEvent(QMouseEvent* event) {
  if (!drawing_ || drag_ == Drag::None) return;
  const QPointF moved = event->localPos() - last_;
  last_ = event->localPos();
  if (drag_ == Drag::Tool) {
    move_tool(pixel(last_));
    return;
  }
  CameraPose pose = drawing_->camera();
  const Vec3 right = pose.up.cross(pose.towards_viewer);
  if (drag_ == Drag::Turn) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(-kTurnPerPixel * moved.x(), pose.up) *
                                  Eigen::AngleAxisd(-kTurnPerPixel * moved.y(), right));
    // About the heart's middle, wherever it was moved to.
    const Vec3 middle = (drawing_->frame().low_mm + drawing_->frame().high_mm) / 2;
    pose.focus_mm = middle + turn * (pose.focus_mm - middle);
    pose.towards_viewer = (turn * pose.towards_viewer).normalized();
    pose.up = (turn * pose.up).normalized();
  } else if (drag_ == Drag::Zoom) {
    pose.height_mm = std::clamp(pose.height_mm * std::exp(0.01 * moved.y()), 5.0, 2000.0);
  } else {
    const double mm = devicePixelRatioF() / drawing_->pixels_per_mm();
    pose.focus_mm += mm * (moved.y() * pose.up - moved.x() * right);
  }
  drawing_->set_camera(pose);
  if (on_camera) on_camera();
}

void HeartWidget::mouseReleaseEvent(QMouseEvent*) {
  drag_ = Drag::None;
  if (drawing_) drawing_->set_moving(false);
}

void HeartWidget::wheelEvent(QWheelEvent* event) {
  if (!drawing_) return;
  const double notches = event->angleDelta().y() / 120.0;
  if (drag_ == Drag::Tool) {
    tool_depth_mm_ += kPushMmPerNotch * notches;
    move_tool(tool_pixel_);
    return;
  }
  CameraPose pose = drawing_->camera();
  pose.height_mm = std::clamp(pose.height_mm * std::pow(0.9, notches), 5.0, 2000.0);
  drawing_->set_camera(pose);
  if (on_camera) on_camera();
}

}  // namespace beatlas::viewer
