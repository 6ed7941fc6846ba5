#include "runtime/viewer/heart_window.h"

#include <QApplication>
#include <QCheckBox>
#include <QCloseEvent>
#include <QComboBox>
#include <QFileInfo>
#include <QLabel>
#include <QPainter>
#include <QPushButton>
#include <QSettings>
#include <QSlider>
#include <QSpinBox>
#include <QStatusBar>
#include <QTimer>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::viewer {
namespace {

constexpr int kFrameMs = 20;
constexpr double kLiftMm = 40;  // how far outside of the heart an idle tool waits

std::int64_t clock_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

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

HeartWindow::HeartWindow(const ViewOptions& options) : options_(options) {
  setWindowTitle("beatlas");
  make_controls();
  make_menus();
  make_shortcuts();
  load_state();
  timer_ = new QTimer(this);
  connect(timer_, &QTimer::timeout, this, [this] { step(); });
  timer_->start(kFrameMs);
}

HeartWindow::~HeartWindow() {
  timer_->stop();
  live_.reset();
}

void HeartWindow::say(const QString& sentence) {
  message_->setText(sentence);
  message_->setVisible(!sentence.isEmpty());
}

QString HeartWindow::message() const { return message_->text(); }

void HeartWindow::guard(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& error) {
    say(QString::fromStdString(error.what()));
  }
}

bool HeartWindow::open(const QString& file) {
  bool opened = false;
  guard([&] {
    show_heart(open_heart(file.toStdString()), file);
    opened = true;
  });
  return opened;
}

void HeartWindow::show_heart(const OpenedHeart& heart, const QString& file) {
  const atlas::Manifest& manifest = heart.atlas->manifest();
  // All that can fail, before anything that is shown changes.
  std::unique_ptr<Touch> touch;
  if (heart.field) {
    TouchSettings settings;
    settings.heart_rate_per_min = std::clamp(60 / manifest.rr_interval_s, 30.0, 220.0);
    touch = std::make_unique<Touch>(manifest, heart.field, settings);
  }
  picture_->show_heart(heart);
  live_.reset();
  heart_ = heart;
  history_.clear();
  say({});
  const HeartFrame& frame = picture_->drawing()->frame();
  if (touch) {
    live_ = std::make_unique<LiveTouch>(std::move(touch), frame.high_mm + Vec3::Constant(kLiftMm));
  }
  for (QWidget* widget :
       std::initializer_list<QWidget*>{touch_, stiffness_, left_atrium_, preset_}) {
    widget->setEnabled(live_ != nullptr);
  }
  volume_->setEnabled(picture_->drawing()->has_volume());
  colour_->setEnabled(picture_->drawing()->has_wall_map());
  cut_image_->setEnabled(picture_->drawing()->has_volume());
  for (const auto& [structure, widgets] : structures_) {
    widgets.first->setEnabled(picture_->drawing()->has(structure));
    widgets.second->setEnabled(picture_->drawing()->has(structure));
  }
  setWindowTitle(QString("beatlas: %1").arg(QFileInfo(file).fileName()));
  remember(file);
  reset();
  options_.view = view_->currentText().toStdString();
}

// As the command line said, on the heart that is there.
void HeartWindow::reset() {
  if (!heart_) return;
  guard([&] {
    const atlas::Manifest& manifest = heart_->atlas->manifest();
    ViewOptions options = options_;
    if (options.volume != VolumePreset::Off && !picture_->drawing()->has_volume()) {
      options.volume = VolumePreset::Off;
    }
    if (!picture_->drawing()->has_wall_map()) options.colour = ColourBy::Structure;
    apply(options, *picture_->drawing());
    view_->setCurrentText(QString::fromStdString(options.view));
    cut_->setCurrentText(options.cut.empty() ? "none" : QString::fromStdString(options.cut));
    cut_offset_->setValue(static_cast<int>(options.cut_offset_mm));
    volume_->setCurrentIndex(static_cast<int>(options.volume));
    colour_->setCurrentIndex(static_cast<int>(options.colour));
    for (const auto& [structure, widgets] : structures_) {
      const Look look = picture_->drawing()->look(structure);
      const QSignalBlocker quiet(widgets.second);
      widgets.first->setChecked(look.visible);
      widgets.second->setValue(static_cast<int>(std::lround(100 * look.opacity)));
    }
    rate_->setValue(static_cast<int>(std::lround(60 / manifest.rr_interval_s)));
    if (live_) {
      stiffness_->setValue(static_cast<int>(manifest.stiffness_n_per_m));
      preset_->setCurrentText("healthy");
      left_atrium_->setValue(
          static_cast<int>(live_->touch().parameters().circulation.left_atrial_mmhg));
      lift_tool();
    }
    touch_->setChecked(false);
    set_playing(true);
  });
}

void HeartWindow::set_playing(bool playing) {
  play_->setChecked(playing);
  play_->setText(playing ? "Pause" : "Play");
  if (live_) {
    haptics::Servo& servo = live_->touch().servo();
    servo.hold_phase(-1);
    servo.set_paused(!playing);
  }
}

void HeartWindow::place_tool(const Vec3& position_mm) {
  if (!live_) {
    say("This package has no field, so it cannot be touched; build it with --scene full.");
    return;
  }
  live_->mouse().move_to(position_mm);
}

void HeartWindow::lift_tool() {
  if (!live_ || picture_->drawing() == nullptr) return;
  const HeartFrame& frame = picture_->drawing()->frame();
  live_->mouse().move_to(frame.high_mm + Vec3::Constant(kLiftMm));
}

void HeartWindow::cut_changed() {
  HeartDrawing* drawing = picture_->drawing();
  if (drawing == nullptr) return;
  const std::string name = cut_->currentText().toStdString();
  const double offset = cut_offset_->value();
  drawing->set_image_on_cut(cut_image_->isChecked());
  if (name == "none") {
    free_cut_from_.reset();
    drawing->set_cut(std::nullopt);
  } else if (name == "free") {
    // It faces who looks at it when it is chosen; then the heart is turned under it.
    if (!free_cut_from_) free_cut_from_ = drawing->camera();
    const Vec3& normal = free_cut_from_->towards_viewer;
    drawing->set_cut(
        CutPlane{.point_mm = drawing->frame().centre_mm + offset * normal, .normal = normal});
  } else {
    free_cut_from_.reset();
    drawing->set_cut(standard_cut(drawing->frame(), name, offset));
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

void HeartWindow::step() {
  HeartDrawing* drawing = picture_->drawing();
  if (drawing == nullptr) return;
  Felt felt;
  if (live_) {
    felt = live_->touch().felt();
    drawing->set_beats(felt.servo.phase);
    picture_->set_field_time(felt.servo.phase * heart_->field->rr_interval_s());
    const ToolPicture tool = live_->touch().tool_picture(felt);
    const bool near = touch_->isChecked() || tool.touching;
    drawing->set_tool(near ? std::optional(tool) : std::nullopt);
    picture_->set_tool(tool.position_mm, tool.radius_mm);
    history_.add(felt);
    plots_->show_panels(history_.panels());
  } else {
    const double now_s = 1e-9 * static_cast<double>(clock_ns());
    const double passed_s = own_time_s_ > 0 ? std::min(now_s - own_time_s_, 0.5) : 0;
    own_time_s_ = now_s;
    if (play_->isChecked()) own_beats_ += passed_s * rate_->value() / 60.0;
    own_beats_ -= std::floor(own_beats_);
    drawing->set_beats(own_beats_);
  }
  if (!phase_->isSliderDown()) {
    const QSignalBlocker quiet(phase_);
    const double phase = live_ ? felt.servo.phase : own_beats_;
    phase_->setValue(static_cast<int>(phase * phase_->maximum()));
  }
  if (!isVisible() || !picture_->draw()) return;
  if (!live_) return;
  lag_ms_ = 1e-6 * static_cast<double>(clock_ns() - felt.clock_ns);
  const PressRow row = history_.last();
  told_->setText(QString("%1 N   %2 mm deep   %3 /min   LV %4 ml, %5 mmHg   picture %6 ms behind")
                     .arg(row.force_n, 0, 'f', 2)
                     .arg(row.depth_mm, 0, 'f', 1)
                     .arg(60 * felt.servo.rate_hz, 0, 'f', 0)
                     .arg(row.volume_ml, 0, 'f', 0)
                     .arg(row.lv_mmhg, 0, 'f', 0)
                     .arg(lag_ms_, 0, 'f', 0));
}

bool HeartWindow::save_png(const QString& file) {
  bool saved = false;
  guard([&] {
    step();
    QImage image(size() * devicePixelRatioF(), QImage::Format_RGB888);
    image.setDevicePixelRatio(devicePixelRatioF());
    render(&image);
    // What OpenGL has drawn comes by another way than the widgets.
    QPainter painter(&image);
    painter.drawImage(picture_->mapTo(this, QPoint(0, 0)), picture_->grabFramebuffer());
    painter.end();
    Picture picture{.width = image.width(), .height = image.height(), .rgb = {}};
    for (int y = 0; y < picture.height; ++y) {
      const uchar* from = image.constScanLine(y);
      picture.rgb.insert(picture.rgb.end(), from, from + 3 * picture.width);
    }
    write_png(picture, file.toStdString());
    saved = true;
  });
  return saved;
}

bool HeartWindow::save_csv(const QString& file) {
  bool saved = false;
  guard([&] {
    history_.write_csv(file.toStdString());
    saved = true;
  });
  return saved;
}

void HeartWindow::remember(const QString& file) {
  if (file.isEmpty()) return;
  QSettings settings("beatlas", "beatlas-view");
  QStringList files = settings.value("recent").toStringList();
  const QString whole = QFileInfo(file).absoluteFilePath();
  files.removeAll(whole);
  files.prepend(whole);
  while (files.size() > 8) files.removeLast();
  settings.setValue("recent", files);
}

void HeartWindow::load_state() {
  const QSettings settings("beatlas", "beatlas-view");
  if (!restoreGeometry(settings.value("geometry").toByteArray())) resize(1180, 760);
  if (!settings.contains("geometry")) {
    say("Drag to turn the heart, wheel to zoom. Tick \"Touch\" (T) and drag into the heart to "
        "press "
        "it. F1 lists the keys.");
  }
}

void HeartWindow::save_state() const {
  QSettings settings("beatlas", "beatlas-view");
  settings.setValue("geometry", saveGeometry());
}

void HeartWindow::closeEvent(QCloseEvent* event) {
  timer_->stop();
  save_state();
  if (live_) live_->stop();
  event->accept();
}

}  // namespace beatlas::viewer
