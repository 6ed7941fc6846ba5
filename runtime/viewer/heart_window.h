#pragma once
/// The window: a heart that beats, controls, plots. Within this room alone, and its tests: here are
/// Qt's types. Widgets that a test drives have object names, which are in heart_window.cpp.

#include <QMainWindow>
#include <array>
#include <map>
#include <memory>
#include <optional>

#include "runtime/viewer/heart_widget.h"
#include "runtime/viewer/history.h"
#include "runtime/viewer/touch.h"

class QCheckBox;
class QComboBox;
class QLabel;
class QMenu;
class QPushButton;
class QSlider;
class QSpinBox;
class QTimer;
class QVBoxLayout;

namespace beatlas::viewer {

class PlotWidget : public QWidget {
 public:
  explicit PlotWidget(QWidget* parent = nullptr);
  void show_panels(std::vector<Panel> panels);

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  std::vector<Panel> panels_;
};

class HeartWindow : public QMainWindow {
 public:
  explicit HeartWindow(const ViewOptions& options);
  ~HeartWindow() override;

  /// What goes wrong appears in the window; what was shown stays then. @return whether it went well
  bool open(const QString& file);
  void show_heart(const OpenedHeart& heart, const QString& file);
  /// Takes the newest tick and draws it; what the timer does.
  void step();

  /// The sentence that is shown; empty: none.
  [[nodiscard]] QString message() const;
  [[nodiscard]] const History& history() const { return history_; }
  [[nodiscard]] HeartWidget& picture() { return *picture_; }
  /// Null without a field: then nothing can be touched.
  [[nodiscard]] LiveTouch* live() { return live_.get(); }
  /// From the end of a tick to the end of the frame that shows it [ms]; the newest frame's.
  [[nodiscard]] double lag_ms() const { return lag_ms_; }
  bool save_png(const QString& file);
  bool save_csv(const QString& file);

 protected:
  void closeEvent(QCloseEvent* event) override;

 private:
  void make_controls();
  void make_structures(QVBoxLayout* column);
  void make_menus();
  void make_shortcuts();
  void say(const QString& sentence);
  void guard(const std::function<void()>& action);
  void set_playing(bool playing);
  void place_tool(const Vec3& position_mm);
  void lift_tool();
  void cut_changed();
  void looks_changed();
  void colour_changed();
  void stiffness_changed();
  void reset();
  void load_state();
  void save_state() const;
  void remember(const QString& file);

  ViewOptions options_;
  std::optional<OpenedHeart> heart_;
  std::unique_ptr<LiveTouch> live_;
  History history_;
  double lag_ms_ = 0;
  double own_beats_ = 0;  ///< without a field
  double own_time_s_ = 0;
  std::optional<CameraPose> free_cut_from_;

  HeartWidget* picture_ = nullptr;
  PlotWidget* plots_ = nullptr;
  QLabel* message_ = nullptr;
  QLabel* told_ = nullptr;
  QPushButton* play_ = nullptr;
  QSpinBox* rate_ = nullptr;
  QSlider* phase_ = nullptr;
  QComboBox* view_ = nullptr;
  QComboBox* cut_ = nullptr;
  QSlider* cut_offset_ = nullptr;
  QCheckBox* cut_image_ = nullptr;
  QComboBox* volume_ = nullptr;
  QComboBox* colour_ = nullptr;
  QCheckBox* touch_ = nullptr;
  QSpinBox* stiffness_ = nullptr;
  QSpinBox* left_atrium_ = nullptr;
  QComboBox* preset_ = nullptr;
  QMenu* recent_ = nullptr;
  QTimer* timer_ = nullptr;
  std::map<Structure, std::pair<QCheckBox*, QSlider*>> structures_;
};

}  // namespace beatlas::viewer
