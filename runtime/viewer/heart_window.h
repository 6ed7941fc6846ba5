#pragma once
/// The window: a heart that beats, controls, plots. Within this room alone, and its tests: here are
/// Qt's types. Widgets that a test drives have object names.

#include <QMainWindow>
#include <array>
#include <map>
#include <memory>
#include <optional>

#include "runtime/viewer/background.h"
#include "runtime/viewer/heart_widget.h"
#include "runtime/viewer/history.h"
#include "runtime/viewer/live_exercise.h"
#include "runtime/viewer/live_touch.h"
#include "runtime/viewer/touch.h"

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QFormLayout;
class QLabel;
class QLineEdit;
class QMenu;
class QPushButton;
class QSlider;
class QSpinBox;
class QSplitter;
class QTimer;
class QVBoxLayout;

namespace beatlas::viewer {

class PlotWidget : public QWidget {
 public:
  explicit PlotWidget(QWidget* parent = nullptr);
  void show_panels(std::vector<Panel> panels);
  /// What it shows, painted at another size.
  [[nodiscard]] QImage image(const QSize& size) const;

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  std::vector<Panel> panels_;
};

/// A package read, with all that takes time.
struct LoadedHeart {
  QString file;
  OpenedHeart opened;
  std::unique_ptr<Touch> touch;                   ///< null without a field
  std::shared_ptr<const Disease> told = nullptr;  ///< what the muscle was told to be; or none
};
/// @param options which say how many fingers there are, and how large
/// @throws Error{InvalidInput} as Touch does.
[[nodiscard]] LoadedHeart loaded_heart(const OpenedHeart& opened, const QString& file,
                                       const ViewOptions& options);

inline constexpr int kCutReachMm = 80;  ///< of the slider that moves a cut, to both sides

class HeartWindow : public QMainWindow {
 public:
  explicit HeartWindow(const ViewOptions& options);
  ~HeartWindow() override;

  /// Reads a package beside the window, which goes on meanwhile; then it is shown. What goes wrong
  /// appears in the window, and what was shown stays. The newest call counts.
  void load(const QString& file);
  [[nodiscard]] bool loading() const { return loading_.busy(); }
  /// @throws Error as HeartDrawing does; what was shown stays then.
  void show_heart(LoadedHeart heart);
  /// As if it were chosen from the list. @param name one of kDevices
  void use_device(const std::string& name, const std::string& detail);
  /// Takes the newest tick and draws it; what the timer does.
  void step();

  /// The sentence that is shown; empty: none.
  [[nodiscard]] QString message() const;
  [[nodiscard]] const History& history() const { return history_; }
  [[nodiscard]] HeartWidget& picture() { return *picture_; }
  /// Null without a field: then nothing can be touched.
  [[nodiscard]] LiveTouch* live() { return live_.get(); }
  /// Null unless one is played: then there is no other touch.
  [[nodiscard]] LiveExercise* exercise() { return exercise_.get(); }
  /// From the end of a tick to the end of the frame that shows it [ms]; the newest frame's.
  [[nodiscard]] double lag_ms() const { return lag_ms_; }
  bool save_png(const QString& file);
  bool save_plots(const QString& file);
  bool save_csv(const QString& file);

 protected:
  void closeEvent(QCloseEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void make_controls();
  void make_messages();  ///< the sentence above the picture, and what the status bar tells
  void make_beat(QVBoxLayout* column);
  void make_cut(QVBoxLayout* column);
  void make_structures(QVBoxLayout* column);
  void make_touch(QVBoxLayout* column);
  /// Puts the column of controls beside the picture and the plots.
  void lay_out(QVBoxLayout* column);
  void make_devices(QFormLayout* form);
  void leave_wheel_to_panel(const QWidget& panel);
  void connect_controls();
  void connect_beat();
  void connect_touch();
  void connect_force();
  void make_menus();
  void make_shortcuts();
  void say(const QString& sentence);
  void guard(const std::function<void()>& action);
  void take_loaded();
  void take_device();
  void open_fingers();
  void take_fingers();
  void set_playing(bool playing);
  void put_tool(const Vec3& position_mm);
  void lift_tool();
  [[nodiscard]] Vec3 resting_place_mm();
  void device_chosen();
  void connect_device();
  void show_device();
  void cut_changed();
  void looks_changed();
  void show_looks();
  void show_view(const ViewOptions& options);
  void reset_force(const ViewOptions& options);
  void show_pressures();
  void make_constants(QFormLayout* form);
  void make_exercise(QVBoxLayout* column);
  void begin_exercise();
  double show_exercise();
  void list_constants();
  void show_constant();
  void show_colourings();
  void colour_changed();
  void stiffness_changed();
  void preset_chosen(const QString& name);
  [[nodiscard]] palpation::PalpationParameters chosen_parameters() const;
  void reset();
  void load_state();
  void load_looks();
  void save_state() const;
  void remember(const QString& file);
  void tell_values(const Felt& felt);
  void show_tools();

  ViewOptions options_;
  std::optional<OpenedHeart> heart_;
  std::shared_ptr<const Disease> told_disease_;  ///< on the heart that is there; or none
  std::unique_ptr<LiveTouch> live_;
  std::unique_ptr<LiveExercise> exercise_;  ///< instead of it
  double exercise_radius_mm_ = 0;
  Background<LoadedHeart> loading_;
  Background<ReadyDevice> connecting_;
  Background<std::vector<ReadyDevice>> opening_fingers_;
  History history_;
  std::vector<Felt> felt_;      ///< of each finger, the tick that is drawn
  std::vector<PressRow> rows_;  ///< just felt
  Panel volumes_;
  double lag_ms_ = 0;
  double own_beats_ = 0;  ///< without a field
  double own_time_s_ = 0;
  bool first_run_ = false;
  std::optional<CutPlane> free_cut_;  ///< chosen, as it is before it is moved
  double cut_offset_mm_ = 0;

  HeartWidget* picture_ = nullptr;
  PlotWidget* plots_ = nullptr;
  QWidget* controls_ = nullptr;
  QSplitter* splitter_ = nullptr;
  QWidget* message_row_ = nullptr;
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
  QComboBox* device_ = nullptr;
  QWidget* detail_row_ = nullptr;
  QLineEdit* detail_ = nullptr;
  QPushButton* connect_ = nullptr;
  QComboBox* colour_ = nullptr;
  QCheckBox* touch_ = nullptr;
  QSpinBox* stiffness_ = nullptr;
  QComboBox* model_ = nullptr;
  QSpinBox* left_atrium_ = nullptr;
  QSpinBox* right_atrium_ = nullptr;
  QComboBox* preset_ = nullptr;
  QComboBox* constant_ = nullptr;  ///< which number of the parameters
  QDoubleSpinBox* constant_value_ = nullptr;
  QPushButton* reset_ = nullptr;
  QLabel* exercise_told_ = nullptr;  ///< null without an exercise, as the next
  QPushButton* exercise_report_ = nullptr;
  std::vector<QPushButton*> mark_buttons_;
  QMenu* recent_ = nullptr;
  QTimer* timer_ = nullptr;
  std::map<int, QString> details_;  ///< of devices, as last told
  std::map<Structure, std::pair<QCheckBox*, QSlider*>> structures_;
};

}  // namespace beatlas::viewer
