#pragma once
#include <memory>
#include <string>

namespace beatlas::viewer {

/// Whether `DISPLAY` names an X server that answers.
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

}  // namespace beatlas::viewer
