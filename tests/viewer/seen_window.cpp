#include "tests/viewer/seen_window.h"

#include <chrono>
#include <thread>

#include <X11/Xlib.h>

namespace beatlas::test {
namespace {

/// Xlib's own handler ends the process. A window that went between being listed and being asked of
/// is none that is seen.
int go_on(::Display* /*display*/, XErrorEvent* /*error*/) { return 0; }

}  // namespace

bool window_is_seen(const std::string& name) {
  ::Display* display = XOpenDisplay(name.c_str());
  if (display == nullptr) return false;
  const XErrorHandler before = XSetErrorHandler(go_on);
  bool seen = false;
  for (int n = 0; n < 200 && !seen; ++n) {
    Window root = 0;
    Window parent = 0;
    Window* children = nullptr;
    unsigned count = 0;
    XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count);
    for (unsigned k = 0; k < count && !seen; ++k) {
      XWindowAttributes about;
      seen = XGetWindowAttributes(display, children[k], &about) != 0 &&
             about.map_state == IsViewable && about.width > 300;
    }
    if (children != nullptr) XFree(children);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  XCloseDisplay(display);
  XSetErrorHandler(before);
  std::this_thread::sleep_for(std::chrono::seconds(1));
  return seen;
}

}  // namespace beatlas::test
