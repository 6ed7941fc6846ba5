#pragma once
/// The drawing as a widget, turned and touched with the mouse. Within this room alone.

#include <QPoint>
#include <functional>
#include <memory>
#include <optional>

#include <QVTKOpenGLNativeWidget.h>

#include "runtime/viewer/drawing.h"
#include "runtime/viewer/stills.h"

namespace beatlas::viewer {

class HeartWidget : public QVTKOpenGLNativeWidget {
 public:
  explicit HeartWidget(QWidget* parent = nullptr);
  ~HeartWidget() override;

  /// Another heart. @throws Error as HeartDrawing; what was drawn stays then.
  /// @param anaglyph, text_scale as DrawingOptions has them
  void show_heart(const OpenedHeart& heart, bool anaglyph, double text_scale = 1);
  /// Null until a heart is shown.
  [[nodiscard]] HeartDrawing* drawing() { return drawing_.get(); }
  /// Draws what has changed. @return whether something was drawn
  bool draw();

  /// Left button: turn, or move the tool.
  void set_touching(bool touching) { touching_ = touching; }
  [[nodiscard]] bool touching() const { return touching_; }
  /// Where the tool shall be [mm, workspace]: at once, where the button is pressed; then moved.
  std::function<void(const Vec3&)> on_tool_put;
  std::function<void(const Vec3&)> on_tool;
  std::function<void()> on_camera;
  /// Where the tool is now and how large.
  void set_tool(const Vec3& position_mm, double radius_mm);
  /// The heart beats: a picture that is slow at full detail is drawn coarser until it stands still.
  void set_beating(bool beating);
  /// When the heart that is seen is, for what lies under the mouse [s].
  void set_field_time(double time_s) { field_time_s_ = time_s; }

 protected:
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;

 private:
  enum class Drag : std::uint8_t { None, Turn, Pan, Zoom, Tool };
  [[nodiscard]] Vec2 pixel(const QPointF& at) const;
  [[nodiscard]] double depth_under(const Vec2& at) const;
  void move_tool(const Vec2& at);

  std::unique_ptr<HeartDrawing> drawing_;
  std::shared_ptr<const field::FieldQuery> field_;  ///< of what is touched
  bool inside_ = false;
  double field_time_s_ = 0;
  bool touching_ = false;
  bool beating_ = false;
  bool slow_ = false;  ///< at full detail, as it is looked at now
  Drag drag_ = Drag::None;
  QPointF last_;
  double tool_depth_mm_ = 0;
  double tool_radius_mm_ = 3;
  Vec2 tool_pixel_ = Vec2::Zero();
};

}  // namespace beatlas::viewer
