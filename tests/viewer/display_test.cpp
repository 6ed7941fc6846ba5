/// A display that others started: it resets when its last client leaves, as X servers do.

#include "runtime/viewer/display.h"

#include <array>
#include <csignal>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

// After GoogleTest, whose names its macros are.
#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <sys/wait.h>
#include <unistd.h>

namespace beatlas::viewer {
namespace {

/// An Xvfb that resets; sets `DISPLAY`.
class ResettingServer {
 public:
  ResettingServer() {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) return;
    process_ = fork();
    if (process_ == 0) {
      const std::string to = std::to_string(ends[1]);
      execlp("Xvfb", "Xvfb", "-displayfd", to.c_str(), "-screen", "0", "320x200x24", "-nolisten",
             "tcp", static_cast<char*>(nullptr));
      _exit(127);
    }
    close(ends[1]);
    std::string number;
    for (char c = 0; read(ends[0], &c, 1) == 1 && c != '\n';) number += c;
    close(ends[0]);
    setenv("DISPLAY", (":" + number).c_str(), 1);
  }
  ~ResettingServer() {
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  ResettingServer(const ResettingServer&) = delete;
  ResettingServer& operator=(const ResettingServer&) = delete;

 private:
  pid_t process_ = -1;
};

/// Leaves a mark on the root window, which a reset takes away.
void leave_mark() {
  ::Display* display = XOpenDisplay(nullptr);
  ASSERT_NE(display, nullptr);
  const unsigned char mark = 1;
  XChangeProperty(display, DefaultRootWindow(display), XA_CURSOR, XA_INTEGER, 8, PropModeReplace,
                  &mark, 1);
  XCloseDisplay(display);
}

bool marked() {
  ::Display* display = nullptr;
  for (int attempt = 0; attempt < 100 && display == nullptr; ++attempt) {
    display = XOpenDisplay(nullptr);
    if (display == nullptr) usleep(20000);
  }
  if (display == nullptr) return false;
  Atom type = 0;
  int format = 0;
  unsigned long count = 0;
  unsigned long left = 0;
  unsigned char* value = nullptr;
  XGetWindowProperty(display, DefaultRootWindow(display), XA_CURSOR, 0, 1, False, XA_INTEGER, &type,
                     &format, &count, &left, &value);
  if (value != nullptr) XFree(value);
  XCloseDisplay(display);
  return count == 1;
}

// While it does so it turns clients away: a picture's own connection, too.
TEST(HasDisplay, KeepsAServerFromResettingBeforeThePictureIsDrawn) {
  const ResettingServer server;
  leave_mark();
  usleep(200000);
  EXPECT_FALSE(marked());  // so this is a server that resets
  for (int attempt = 0; attempt < 100 && !has_display(); ++attempt) usleep(20000);
  leave_mark();
  usleep(200000);
  EXPECT_TRUE(marked());
}

TEST(HasDisplay, IsFalseWithoutAServerThatAnswers) {
  setenv("DISPLAY", ":987", 1);
  EXPECT_FALSE(has_display());
  unsetenv("DISPLAY");
  EXPECT_FALSE(has_display());
}

}  // namespace
}  // namespace beatlas::viewer
