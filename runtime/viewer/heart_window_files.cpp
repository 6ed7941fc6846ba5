#include <QAction>
#include <QCheckBox>
#include <QComboBox>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QLabel>
#include <QMenu>
#include <QMenuBar>
#include <QMessageBox>
#include <QPainter>
#include <QPushButton>
#include <QSettings>
#include <QShortcut>
#include <QSlider>
#include <QSplitter>

#include "runtime/viewer/heart_window.h"

namespace beatlas::viewer {
namespace {

constexpr int kRecentFiles = 8;

const char* const kKeys =
    "Mouse\n"
    "  drag: turn    right drag or wheel: zoom    shift or middle drag: move\n"
    "  touch on (or Ctrl): drag the tool; the wheel pushes it deeper\n\n"
    "Space  play, pause\n"
    "T  touch on, off\n"
    "1 to 9  views: anterior, left, right, posterior, superior, inferior, short-axis, apex, "
    "four-chamber\n"
    "X  no cut, or the four-chamber one    [ and ]  move the cut by 2 mm\n"
    "V  volume off, muscle, blood    R  reset\n"
    "Ctrl+1 to 4  in an exercise: mark what is touched\n"
    "Ctrl+O  open    Ctrl+S  save a picture    Ctrl+Q  quit\n"
    "Ctrl+E  export the plots as CSV    Ctrl+P  export the plots as PNG\n"
    "F1  these keys\n\n"
    "\"Blood\" shows the bright cavities through the beat, not measured flow.\n"
    "For research and training. Not a medical device, not for diagnosis.";

QSettings user_settings() { return QSettings("beatlas", "beatlas-view"); }

Picture picture_of(const QImage& image) {
  Picture picture{.width = image.width(), .height = image.height(), .rgb = {}};
  for (int y = 0; y < picture.height; ++y) {
    const uchar* from = image.constScanLine(y);
    picture.rgb.insert(picture.rgb.end(), from, from + 3 * picture.width);
  }
  return picture;
}

}  // namespace

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
    write_png(picture_of(image), file.toStdString());
    saved = true;
  });
  return saved;
}

bool HeartWindow::save_plots(const QString& file) {
  bool saved = false;
  guard([&] {
    constexpr int kWidth = 800;  // as it is printed, whatever the window's size
    constexpr int kHeight = 1200;
    write_png(picture_of(plots_->image(QSize(kWidth, kHeight))), file.toStdString());
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
  QSettings settings = user_settings();
  QStringList files = settings.value("recent").toStringList();
  const QString whole = QFileInfo(file).absoluteFilePath();
  files.removeAll(whole);
  files.prepend(whole);
  while (files.size() > kRecentFiles) files.removeLast();
  settings.setValue("recent", files);
}

void HeartWindow::load_state() {
  const QSettings settings = user_settings();
  first_run_ = !settings.contains("geometry");
  if (!restoreGeometry(settings.value("geometry").toByteArray())) resize(1180, 760);
  splitter_->restoreState(settings.value("splitter").toByteArray());
}

// What was chosen the last time, where the command line says nothing of it.
void HeartWindow::load_looks() {
  const QSettings settings = user_settings();
  const bool told = !options_.opacity.empty() || options_.volume != VolumePreset::Off ||
                    options_.colour != ColourBy::Structure || !options_.cut.empty() ||
                    options_.free_cut.has_value() || !options_.inside.empty();
  if (told || !settings.contains("volume")) return;
  if (picture_->drawing()->has_volume()) {
    volume_->setCurrentIndex(settings.value("volume").toInt());
  }
  if (options_.image_on_cut) cut_image_->setChecked(settings.value("cut_image", true).toBool());
  for (const auto& [structure, widgets] : structures_) {
    const QString name = "looks/" + widgets.first->objectName();
    if (!settings.contains(name)) continue;
    const QStringList look = settings.value(name).toStringList();
    if (look.size() != 2) continue;
    widgets.first->setChecked(look[0] == "seen");
    widgets.second->setValue(look[1].toInt());
  }
}

void HeartWindow::save_state() const {
  QSettings settings = user_settings();
  settings.setValue("geometry", saveGeometry());
  settings.setValue("splitter", splitter_->saveState());
  // A tool in a cavity and a colouring have looks of their own, which are not the user's.
  if (!heart_ || !options_.inside.empty() || picture_->drawing()->colouring() != nullptr) return;
  settings.setValue("volume", volume_->currentIndex());
  settings.setValue("cut_image", cut_image_->isChecked());
  for (const auto& [structure, widgets] : structures_) {
    settings.setValue("looks/" + widgets.first->objectName(),
                      QStringList{widgets.first->isChecked() ? "seen" : "hidden",
                                  QString::number(widgets.second->value())});
  }
}

void HeartWindow::make_menus() {
  const auto save_as = [this](const char* title, const char* name, const char* kind,
                              bool (HeartWindow::*save)(const QString&)) {
    const QString folder = user_settings().value("folder").toString();
    const QString file =
        QFileDialog::getSaveFileName(this, title, QDir(folder).filePath(name), kind);
    if (file.isEmpty() || !(this->*save)(file)) return;
    user_settings().setValue("folder", QFileInfo(file).absolutePath());
  };
  QMenu* file = menuBar()->addMenu("&File");
  file->addAction(
      "&Open...", this,
      [this] {
        const QStringList known = user_settings().value("recent").toStringList();
        const QString folder = known.isEmpty() ? QString() : QFileInfo(known[0]).absolutePath();
        const QString name =
            QFileDialog::getOpenFileName(this, "Open an atlas", folder, "Atlases (*.beatlas)");
        if (!name.isEmpty()) load(name);
      },
      QKeySequence::Open);
  recent_ = file->addMenu("Open &recent");
  recent_->setObjectName("recent");
  connect(recent_, &QMenu::aboutToShow, this, [this] {
    recent_->clear();
    for (const QString& name : user_settings().value("recent").toStringList()) {
      recent_->addAction(name, this, [this, name] { load(name); });
    }
  });
  file->addAction(
      "&Save a picture...", this,
      [=] { save_as("Save a picture", "heart.png", "Pictures (*.png)", &HeartWindow::save_png); },
      QKeySequence::Save);
  file->addAction(
      "&Export the plots as CSV...", this,
      [=] { save_as("Export the plots", "felt.csv", "Tables (*.csv)", &HeartWindow::save_csv); },
      QKeySequence("Ctrl+E"));
  file->addAction(
      "Export the &plots as PNG...", this,
      [=] {
        save_as("Export the plots", "plots.png", "Pictures (*.png)", &HeartWindow::save_plots);
      },
      QKeySequence("Ctrl+P"));
  file->addSeparator();
  file->addAction(
      "&Quit", this, [this] { close(); }, QKeySequence("Ctrl+Q"));
  QMenu* help = menuBar()->addMenu("&Help");
  help->addAction(
      "&Keys", this, [this] { QMessageBox::information(this, "Keys", kKeys); }, QKeySequence("F1"));
}

void HeartWindow::make_shortcuts() {
  const auto on = [this](const char* keys, const std::function<void()>& action) {
    connect(new QShortcut(QKeySequence(keys), this), &QShortcut::activated, this, action);
  };
  on("Space", [this] { play_->toggle(); });
  on("T", [this] { touch_->toggle(); });
  on("R", [this] { reset(); });
  on("V", [this] { volume_->setCurrentIndex((volume_->currentIndex() + 1) % volume_->count()); });
  on("X", [this] { cut_->setCurrentIndex(cut_->currentIndex() == 0 ? 5 : 0); });
  on("[", [this] { cut_offset_->setValue(cut_offset_->value() - 2); });
  on("]", [this] { cut_offset_->setValue(cut_offset_->value() + 2); });
  for (int n = 0; n < view_->count(); ++n) {
    on(std::to_string(n + 1).c_str(), [this, n] { view_->setCurrentIndex(n); });
  }
}

}  // namespace beatlas::viewer
