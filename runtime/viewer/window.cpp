#include "runtime/viewer/window.h"

#include <QApplication>
#include <QSurfaceFormat>
#include <string>

#include <QVTKOpenGLNativeWidget.h>

#include "runtime/viewer/heart_window.h"

namespace beatlas::viewer {

int show_window(const ViewOptions& options, const std::optional<OpenedHeart>& heart) {
  QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
  int count = 1;
  std::string name = "beatlas-view";
  char* names[] = {name.data(), nullptr};
  QApplication application(count, names);
  HeartWindow window(options);
  window.show();
  if (heart) window.show_heart(*heart, QString::fromStdString(options.package.string()));
  return QApplication::exec();
}

}  // namespace beatlas::viewer
