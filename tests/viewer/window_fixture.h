#pragma once
/// The viewer's window for tests: a display, an application, packages; a user's own state stays.

#include <QApplication>
#include <QSettings>
#include <QSurfaceFormat>
#include <QTest>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "runtime/viewer/display.h"
#include "runtime/viewer/heart_window.h"
#include "tests/package/sample_package.h"

namespace beatlas::test {

class WindowFixture : public testing::Test {
 public:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    setenv("XDG_CONFIG_HOME", folder_->path().c_str(), 1);  // a user's own state stays
    setenv("QT_QPA_PLATFORM", "xcb", 1);
    display_ = std::make_unique<viewer::Display>();
    QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
    static int count = 1;
    static char name[] = "window_test";
    static char* names[] = {name, nullptr};
    application_ = std::make_unique<QApplication>(count, names);
    pack::write_package(folder_->path() / "heart.beatlas", sample_content(10, 45, 2, 4));
    pack::PackageContent seen = sample_content(6, 30, 2, 3);
    seen.fields.clear();
    pack::write_package(folder_->path() / "seen.beatlas", seen);
    std::ofstream(folder_->path() / "foreign.beatlas") << "nothing of the kind";
    std::filesystem::copy_file(folder_->path() / "heart.beatlas",
                               folder_->path() / "broken.beatlas");
    std::filesystem::resize_file(folder_->path() / "broken.beatlas",
                                 std::filesystem::file_size(folder_->path() / "heart.beatlas") / 2);
  }
  static void TearDownTestSuite() {
    application_.reset();
    display_.reset();
    folder_.reset();
  }
  void SetUp() override {
    QSettings settings("beatlas", "beatlas-view");
    settings.clear();
    settings.setValue("geometry", QByteArray("none"));  // not the first run
  }
  static bool load(viewer::HeartWindow& window, const char* name) {
    window.load(file(name));
    return QTest::qWaitFor([&] { return !window.loading(); }, 20000);
  }
  static QString file(const char* name) {
    return QString::fromStdString((folder_->path() / name).string());
  }
  static std::unique_ptr<viewer::HeartWindow> window(viewer::ViewOptions options = {}) {
    if (options.view.empty()) options.view = "anterior";
    auto made = std::make_unique<viewer::HeartWindow>(options);
    // A processor draws here, and takes time by the pixel. A size that is remembered stays.
    const QByteArray kept = QSettings("beatlas", "beatlas-view").value("geometry").toByteArray();
    if (kept.isEmpty() || kept == "none") made->resize(800, 560);
    made->show();
    EXPECT_TRUE(QTest::qWaitForWindowExposed(made.get()));
    return made;
  }
  template <class Widget>
  static Widget& find(viewer::HeartWindow& window, const char* name) {
    auto* found = window.findChild<Widget*>(name);
    if (found == nullptr) throw std::runtime_error(std::string("no widget ") + name);
    return *found;
  }

  static inline std::unique_ptr<TemporaryFolder> folder_;
  static inline std::unique_ptr<viewer::Display> display_;
  static inline std::unique_ptr<QApplication> application_;
};

}  // namespace beatlas::test
