#pragma once
#include <functional>
#include <string>

namespace beatlas::viewer {

/// Whether `DISPLAY` names an X server that answers. The first that does keeps a connection of
/// ours.
[[nodiscard]] bool has_display();

/// A display to draw on: the one there is, or an Xvfb of our own that ends with this object (and
/// with the process, however that ends). Sets `DISPLAY`.
class Display {
 public:
  /// @throws Error{Machine} if there is no display and Xvfb is not installed or does not start.
  Display();
  ~Display();
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

 private:
  int server_ = -1;  // process
};

/// While it lives, a display that goes away ends the program as other trouble does: `on_lost`, one
/// sentence, exit status 5. Xlib and Qt would end it with status 1, in the middle of whatever other
/// threads do. One at a time; made after the QApplication, which has a handler of its own.
class LostDisplayWatch {
 public:
  /// @param on_lost must not throw nor draw; called on the thread that met the loss
  LostDisplayWatch(std::string program, std::function<void()> on_lost);
  ~LostDisplayWatch();
  LostDisplayWatch(const LostDisplayWatch&) = delete;
  LostDisplayWatch& operator=(const LostDisplayWatch&) = delete;

 private:
  static void end();

  std::string program_;
  std::function<void()> on_lost_;
};

}  // namespace beatlas::viewer
