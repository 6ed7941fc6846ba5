#include "runtime/viewer/heart_window.h"

#include <QApplication>
#include <QCheckBox>
#include <QCloseEvent>
#include <QComboBox>
#include <QFileInfo>
#include <QFont>
#include <QFontInfo>
#include <QLabel>
#include <QPainter>
#include <QPushButton>
#include <QSignalBlocker>
#include <QSlider>
#include <QSpinBox>
#include <QStatusBar>
#include <QTimer>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "runtime/app/touch.h"
#include "runtime/field/surface_point.h"
#include "runtime/viewer/tick_times.h"
#include "runtime/viewer/volume_plot.h"

namespace beatlas::viewer {
namespace {

constexpr int kFrameMs = 20;
constexpr double kLiftMm = 40;      // how far outside of the heart an idle tool waits
constexpr int kWithControls = 480;  // pixels of the window's width
constexpr int kWithPlots = 720;

const char* const kHint =
    "Drag to turn the heart, wheel to zoom. Tick \"Touch\" (T) and drag into the heart to press "
    "it. "
    "F1 lists the keys.";

}  // namespace

PlotWidget::PlotWidget(QWidget* parent) : QWidget(parent) { setMinimumSize(180, 120); }

void PlotWidget::show_panels(std::vector<Panel> panels) {
  panels_ = std::move(panels);
  update();
}

void PlotWidget::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  paint_panels(painter, rect(), panels_);
}

QImage PlotWidget::image(const QSize& size) const {
  QImage image(size, QImage::Format_RGB888);
  QPainter painter(&image);
  QFont words = font();
  words.setPixelSize(std::max(13, size.width() / 40));
  painter.setFont(words);
  paint_panels(painter, image.rect(), panels_);
  return image;
}

HeartWindow::HeartWindow(const ViewOptions& options) : options_(options) {
  setWindowTitle("beatlas");
  QFont words = font();
  words.setPointSizeF(options_.text_scale * QFontInfo(words).pointSizeF());
  setFont(words);
  make_controls();
  connect_controls();
  make_menus();
  make_shortcuts();
  load_state();
  timer_ = new QTimer(this);
  connect(timer_, &QTimer::timeout, this, [this] { step(); });
  timer_->start(kFrameMs);
}

HeartWindow::~HeartWindow() {
  timer_->stop();
  exercise_.reset();
  live_.reset();
}

void HeartWindow::say(const QString& sentence) {
  message_->setText(sentence);
  message_row_->setVisible(!sentence.isEmpty());
}

QString HeartWindow::message() const { return message_->text(); }

void HeartWindow::guard(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& error) {
    say(QString::fromStdString(error.what()));
  }
}

LoadedHeart loaded_heart(const OpenedHeart& opened, const QString& file,
                         const ViewOptions& options) {
  LoadedHeart heart{.file = file, .opened = opened, .touch = nullptr};
  if (!opened.touched) return heart;
  const atlas::Manifest& manifest = opened.atlas->manifest();
  TouchSettings settings;
  settings.heart_rate_per_min = std::clamp(60 / manifest.rr_interval_s, 30.0, 220.0);
  settings.inside = !opened.inside.empty() && opened.inside != app::kPericardium;
  settings.effusion_mm = options.effusion_mm;
  settings.model = model_of(options);
  if (options.told) {
    heart.told = std::make_shared<const Disease>(disease_of(opened, *options.told));
    settings.disease = heart.told;
  }
  if (options.tool_radius_mm > 0) settings.tool_radius_mm = options.tool_radius_mm;
  for (const app::PlayArguments& finger : options.fingers) {
    settings.radii_mm.push_back(finger.tool_radius_mm);
  }
  heart.touch = touch_of(opened, settings);
  return heart;
}

void HeartWindow::load(const QString& file) {
  if (exercise_) {
    say("An exercise is played on this heart; close the window to end it, it is kept.");
    return;
  }
  loading_.begin([file, options = options_] {
    return loaded_heart(open_heart(file.toStdString(), options.inside, options.valve), file,
                        options);
  });
  say(QString("%1 is read ...").arg(QFileInfo(file).fileName()));
}

void HeartWindow::take_loaded() {
  guard([&] {
    std::optional<LoadedHeart> heart = loading_.take();
    if (heart) show_heart(std::move(*heart));
  });
}

void HeartWindow::show_heart(LoadedHeart heart) {
  picture_->show_heart(heart.opened, options_.anaglyph, options_.text_scale);
  connecting_.drop();
  opening_fingers_.drop();
  live_.reset();
  heart_ = heart.opened;
  told_disease_ = heart.told;
  history_.clear();
  volumes_ = volume_panel(heart_->atlas->manifest());
  say(first_run_ ? kHint : "");
  HeartDrawing& drawing = *picture_->drawing();
  if (options_.exercise) {
    begin_exercise();
    for (QWidget* widget : std::initializer_list<QWidget*>{play_, rate_, phase_}) {
      widget->setEnabled(false);  // the heart beats as the exercise has it
    }
  } else if (heart.touch) {
    if (heart.touch->pericardium() != nullptr) {
      drawing.set_pericardium(heart.touch->pericardium()->lattice());
    }
    live_ = std::make_unique<LiveTouch>(std::move(heart.touch), resting_place_mm());
    open_fingers();
  }
  for (QWidget* widget : std::initializer_list<QWidget*>{touch_, device_, model_, stiffness_,
                                                         left_atrium_, right_atrium_, preset_}) {
    widget->setEnabled(live_ != nullptr);
  }
  const QSignalBlocker quiet(device_);
  device_->setCurrentIndex(0);
  show_device();
  volume_->setEnabled(drawing.has_volume());
  show_colourings();
  cut_image_->setEnabled(drawing.has_volume());
  for (const auto& [structure, widgets] : structures_) {
    widgets.first->setEnabled(drawing.has(structure));
    widgets.second->setEnabled(drawing.has(structure));
  }
  setWindowTitle(QString("beatlas: %1").arg(QFileInfo(heart.file).fileName()));
  remember(heart.file);
  reset();
  load_looks();
}

// As the command line said, on the heart that is there.
void HeartWindow::reset() {
  if (!heart_) return;
  guard([&] {
    ViewOptions options = options_;
    if (options.volume != VolumePreset::Off && !picture_->drawing()->has_volume()) {
      options.volume = VolumePreset::Off;
    }
    for (const Structure structure : kAllStructures) {
      picture_->drawing()->set_look(structure, default_look(structure));
    }
    if (!picture_->drawing()->can_colour_by(options.colour)) options.colour = ColourBy::Structure;
    apply(options, *picture_->drawing());
    show_view(options);
    reset_force(options);
    touch_->setChecked(false);
    set_playing(true);
  });
}

// The widgets as apply() has left the drawing. They say nothing themselves: what they make of a
// change would undo what was asked for beside it.
void HeartWindow::show_view(const ViewOptions& options) {
  const std::array<QSignalBlocker, 6> quiet{QSignalBlocker(view_),       QSignalBlocker(cut_),
                                            QSignalBlocker(cut_offset_), QSignalBlocker(cut_image_),
                                            QSignalBlocker(volume_),     QSignalBlocker(colour_)};
  view_->setCurrentText(QString::fromStdString(options.view));
  free_cut_ = options.free_cut;
  const std::string cut = options.cut.empty() ? "none" : options.cut;
  cut_->setCurrentText(QString::fromStdString(free_cut_ ? "free" : cut));
  // The slider has whole millimetres, and reaches as far as it was told to be.
  cut_offset_mm_ = free_cut_ ? 0 : options.cut_offset_mm;
  const int reach_mm = std::max(kCutReachMm, static_cast<int>(std::ceil(std::abs(cut_offset_mm_))));
  cut_offset_->setRange(-reach_mm, reach_mm);
  cut_offset_->setValue(static_cast<int>(std::lround(cut_offset_mm_)));
  cut_image_->setChecked(options.image_on_cut);
  volume_->setCurrentIndex(static_cast<int>(options.volume));
  colour_->setCurrentIndex(static_cast<int>(options.colour));
  show_looks();
}

// Rate, muscle and circulation are told in any case: a widget that shows what is wished says
// nothing, though a constant was changed beside it.
void HeartWindow::reset_force(const ViewOptions& options) {
  const atlas::Manifest& manifest = heart_->atlas->manifest();
  const double per_min =
      options.heart_rate_per_min > 0 ? options.heart_rate_per_min : 60 / manifest.rr_interval_s;
  const std::array<QSignalBlocker, 3> quiet{QSignalBlocker(rate_), QSignalBlocker(stiffness_),
                                            QSignalBlocker(preset_)};
  rate_->setValue(static_cast<int>(std::lround(per_min)));
  stiffness_->setValue(static_cast<int>(manifest.stiffness_n_per_m));
  preset_->setCurrentText(
      QString::fromStdString(options.told ? options.told_name : options.preset));
  if (!live_) return;
  Touch& touch = live_->touch();
  touch.set_heart_rate(std::clamp<double>(per_min, rate_->minimum(), rate_->maximum()));
  touch.set_stiffness(manifest.stiffness_n_per_m);
  preset_chosen(preset_->currentText());
  model_->setCurrentIndex(model_of(options) == "patch" ? 1 : 0);
  stiffness_->setEnabled(model_->currentIndex() == 0);
  lift_tool();
}

void HeartWindow::set_playing(bool playing) {
  play_->setChecked(playing);
  play_->setText(playing ? "Pause" : "Play");
  if (live_) {
    live_->touch().hold_phase(-1);
    live_->touch().set_paused(!playing);
  }
}

void HeartWindow::put_tool(const Vec3& position_mm) {
  if (exercise_) {
    exercise_->mouse().put_at(position_mm);
    return;
  }
  if (!live_) {
    say("This package has no field, so it cannot be touched; build it with --scene full.");
    return;
  }
  live_->mouse().put_at(position_mm);
}

void HeartWindow::lift_tool() {
  if (!live_ || picture_->drawing() == nullptr) return;
  // Not dragged there: the heart may lie on the way.
  live_->mouse().put_at(resting_place_mm());
}

// Of an idle tool: beside the heart, in the middle of the cavity, or in the fluid beside the left
// ventricle's free wall.
Vec3 HeartWindow::resting_place_mm() {
  const HeartFrame& frame = picture_->drawing()->frame();
  if (heart_->inside == app::kPericardium) {
    const Vec3 outward = free_wall_direction(frame, heart_->touched->centre_mm()).normalized();
    const atlas::Manifest& manifest = heart_->atlas->manifest();
    const double end_diastole_s =
        manifest.rr_interval_s * manifest.end_diastole / std::max(1, manifest.phase_count());
    return field::surface_point_mm(*heart_->touched, outward, end_diastole_s) +
           options_.effusion_mm / 2 * outward;
  }
  if (!heart_->inside.empty()) return heart_->touched->centre_mm();
  return frame.high_mm + Vec3::Constant(kLiftMm);
}

void HeartWindow::cut_changed() {
  HeartDrawing* drawing = picture_->drawing();
  if (drawing == nullptr) return;
  const std::string name = cut_->currentText().toStdString();
  drawing->set_image_on_cut(cut_image_->isChecked());
  if (name == "none") {
    free_cut_.reset();
    drawing->set_cut(std::nullopt);
  } else if (name == "free") {
    // It faces who looks at it when it is chosen; then the heart is turned under it.
    if (!free_cut_) {
      free_cut_ = CutPlane{.point_mm = drawing->frame().centre_mm,
                           .normal = drawing->camera().towards_viewer};
    }
    drawing->set_cut(CutPlane{.point_mm = free_cut_->point_mm + cut_offset_mm_ * free_cut_->normal,
                              .normal = free_cut_->normal});
  } else {
    free_cut_.reset();
    drawing->set_cut(standard_cut(drawing->frame(), name, cut_offset_mm_));
  }
}

void HeartWindow::looks_changed() {
  HeartDrawing* drawing = picture_->drawing();
  if (drawing == nullptr) return;
  for (const auto& [structure, widgets] : structures_) {
    Look look = drawing->look(structure);
    look.visible = widgets.first->isChecked();
    look.opacity = widgets.second->value() / 100.0;
    drawing->set_look(structure, look);
  }
}

// The widgets as the drawing is.
void HeartWindow::show_looks() {
  for (const auto& [structure, widgets] : structures_) {
    const Look look = picture_->drawing()->look(structure);
    const QSignalBlocker quiet_seen(widgets.first);
    const QSignalBlocker quiet_opacity(widgets.second);
    widgets.first->setChecked(look.visible);
    widgets.second->setValue(static_cast<int>(std::lround(100 * look.opacity)));
  }
}

// Those that a device moves, and the mouse's where it may touch.
void HeartWindow::show_tools() {
  Touch& touch = live_->touch();
  HeartDrawing& drawing = *picture_->drawing();
  std::vector<ToolPicture> tools;
  for (std::size_t n = 0; n < touch.fingers(); ++n) {
    const Felt& felt = felt_[n];
    ToolPicture tool = touch.tool_picture(felt, n);
    const std::string moved_by = live_->finger(n).device();
    if (n == 0) picture_->set_tool(tool.position_mm, tool.radius_mm);
    const bool near = n == 0 && moved_by == live_->mouse().name()
                          ? touch_->isChecked() || tool.touching
                          : !moved_by.empty();
    if (!near && touch.fingers() == 1) continue;
    tool.shown = near;
    if (near) tool.taxels = touch.taxels(felt, drawing.camera().right(), n);
    tools.push_back(std::move(tool));
  }
  drawing.set_tools(std::move(tools));
}

void HeartWindow::step() {
  take_loaded();
  take_device();
  take_fingers();
  HeartDrawing* drawing = picture_->drawing();
  if (drawing == nullptr) return;
  Felt felt;
  double phase = own_beats_;
  if (exercise_) {
    phase = show_exercise();
  } else if (live_) {
    felt_.clear();
    for (std::size_t n = 0; n < live_->touch().fingers(); ++n) {
      felt_.push_back(live_->touch().felt(n));
    }
    felt = felt_.front();
    phase = felt.servo.phase;
    drawing->set_beats(phase);
    picture_->set_field_time(felt.servo.phase * heart_->field->rr_interval_s());
    show_tools();
    live_->touch().take_rows(rows_);
    for (const PressRow& row : rows_) history_.add(row);
    std::vector<Panel> panels = history_.panels();
    volumes_.now = felt.servo.phase * heart_->field->rr_interval_s();
    panels.push_back(volumes_);
    plots_->show_panels(std::move(panels));
  } else {
    const double now_s = 1e-9 * static_cast<double>(clock_ns());
    const double passed_s = own_time_s_ > 0 ? std::min(now_s - own_time_s_, 0.5) : 0;
    own_time_s_ = now_s;
    if (play_->isChecked()) own_beats_ += passed_s * rate_->value() / 60.0;
    own_beats_ -= std::floor(own_beats_);
    drawing->set_beats(own_beats_);
    volumes_.now = own_beats_ * heart_->atlas->manifest().rr_interval_s;
    plots_->show_panels({volumes_});
  }
  if (!phase_->isSliderDown()) {
    const QSignalBlocker quiet(phase_);
    phase_->setValue(static_cast<int>(phase * phase_->maximum()));
  }
  picture_->set_beating(live_ ? felt.servo.rate_hz > 0.01 : play_->isChecked() || exercise_);
  if (!isVisible() || !picture_->draw()) return;
  if (!live_) return;
  lag_ms_ = 1e-6 * static_cast<double>(clock_ns() - felt.clock_ns);
  tell_values(felt);
}

void HeartWindow::tell_values(const Felt& felt) {
  const PressRow row = history_.last();
  QString where;
  if (const auto wall = live_->touch().touched_wall(felt)) {
    const std::string_view name = palpation::segment_name(wall->segment);
    where = QString::fromUtf8(name.data(), static_cast<int>(name.size())).replace('_', ' ');
    if (wall->tissue.scar > 0) where += ", scar";
    if (wall->tissue.alpha < 1) where += ", contracts less";
    where = " (" + where + ")";
  }
  if (const auto known_mm = live_->touch().known_to_mm(felt)) {
    where += QString(", surface known to %1 mm").arg(*known_mm, 0, 'f', 1);
  }
  QString others;
  for (std::size_t n = 1; n < felt_.size(); ++n) {
    others += QString("   %1: %2 N").arg(n + 1).arg(press_row(felt_[n]).force_n, 0, 'f', 2);
  }
  told_->setText(QString("%1: %2 N%10   %3 mm deep%8   %4 /min   LV %5 ml, %6 mmHg   %9 l/min   "
                         "picture %7 ms behind")
                     .arg(QString::fromStdString(live_->device()))
                     .arg(row.force_n, 0, 'f', 2)
                     .arg(row.depth_mm, 0, 'f', 1)
                     .arg(60 * felt.servo.rate_hz, 0, 'f', 0)
                     .arg(row.volume_ml, 0, 'f', 0)
                     .arg(row.lv_mmhg, 0, 'f', 0)
                     .arg(lag_ms_, 0, 'f', 0)
                     .arg(where)
                     .arg(felt.circulation.beat.output_l_per_min, 0, 'f', 1)
                     .arg(others));
}

void HeartWindow::closeEvent(QCloseEvent* event) {
  timer_->stop();
  save_state();
  if (exercise_) exercise_->stop();
  if (live_) live_->stop();
  event->accept();
}

// The wheel over a control scrolls the panel: a value changes where somebody means it to.
bool HeartWindow::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() != QEvent::Wheel) return QMainWindow::eventFilter(watched, event);
  event->ignore();
  return true;
}

// A small window is the picture's alone; the keys still do what the controls do.
void HeartWindow::resizeEvent(QResizeEvent* event) {
  QMainWindow::resizeEvent(event);
  controls_->setVisible(width() >= kWithControls);
  // Under a device that plays an exercise force is felt, and not seen.
  plots_->setVisible(width() >= kWithPlots && !(exercise_ && !exercise_->with_mouse()));
}

}  // namespace beatlas::viewer
