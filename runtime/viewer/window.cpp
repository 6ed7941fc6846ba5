#include "runtime/viewer/window.h"

#include <QApplication>
#include <QSurfaceFormat>
#include <cstdio>
#include <string>

#include <QVTKOpenGLNativeWidget.h>

#include "runtime/base/error.h"
#include "runtime/base/interrupts.h"
#include "runtime/viewer/display.h"
#include "runtime/viewer/heart_window.h"

namespace beatlas::viewer {
namespace {

// What goes wrong is said in our own words; Qt's remarks on the desktop help nobody.
void keep_serious(QtMsgType type, const QMessageLogContext&, const QString& text) {
  if (type != QtCriticalMsg && type != QtFatalMsg) return;
  (void)std::fprintf(stderr, "beatlas-play: %s\n", text.toLocal8Bit().constData());
}

}  // namespace

int show_window(const ViewOptions& options, const std::optional<OpenedHeart>& heart) {
  qInstallMessageHandler(keep_serious);
  QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
  int count = 1;
  std::string name = "beatlas-view";
  char* names[] = {name.data(), nullptr};
  // Before Qt and the drawing begin their threads.
  const Interrupts interrupts([] {
    QCoreApplication* running = QCoreApplication::instance();
    if (running == nullptr) return;
    QMetaObject::invokeMethod(
        running,
        [] {
          QApplication::closeAllWindows();  // the last force is zero then
          QApplication::exit(static_cast<int>(ErrorCode::Machine));
        },
        Qt::QueuedConnection);
  });
  QApplication::setAttribute(
      Qt::AA_EnableHighDpiScaling);  // sizes follow the display's dots an inch
  QApplication::setAttribute(Qt::AA_UseHighDpiPixmaps);
  QApplication application(count, names);
  HeartWindow window(options);
  const LostDisplayWatch watch("beatlas-play", [&window] {
    // The last force is zero then.
    if (window.exercise() != nullptr) window.exercise()->stop();
    if (window.live() != nullptr) window.live()->stop();
  });
  window.show();
  if (heart) {
    window.show_heart(
        loaded_heart(*heart, QString::fromStdString(options.package.string()), options));
    if (!options.exercise) window.use_device(options.device, options.device_detail);
  }
  interrupts.check();
  const int code = QApplication::exec();
  interrupts.check();
  return code;
}

}  // namespace beatlas::viewer
