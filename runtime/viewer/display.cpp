#include "runtime/viewer/display.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>

#include <X11/Xlib.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "runtime/base/error.h"

namespace beatlas::viewer {
namespace {

constexpr int kStartMs = 20000;

// The number that Xvfb writes when it is ready; empty if it never does.
std::string read_line(int from) {
  std::string line;
  while (line.find('\n') == std::string::npos && line.size() < 16) {
    pollfd wait{.fd = from, .events = POLLIN, .revents = 0};
    if (poll(&wait, 1, kStartMs) <= 0) return {};
    std::array<char, 16> bytes{};
    const ssize_t got = read(from, bytes.data(), bytes.size());
    if (got <= 0) return {};
    line.append(bytes.data(), static_cast<std::size_t>(got));
  }
  return line.substr(0, line.find('\n'));
}

std::atomic<LostDisplayWatch*> watching{nullptr};

}  // namespace

LostDisplayWatch::LostDisplayWatch(std::string program, std::function<void()> on_lost)
    : program_(std::move(program)), on_lost_(std::move(on_lost)) {
  watching = this;
  XSetIOErrorHandler([](::Display*) {
    end();
    return 0;
  });
  // Where it is not Xlib that meets the loss, Qt calls exit(); nothing else does while we watch.
  [[maybe_unused]] static const int at_exit = std::atexit(end);
}

LostDisplayWatch::~LostDisplayWatch() {
  XSetIOErrorHandler(nullptr);
  watching = nullptr;
}

void LostDisplayWatch::end() {
  const LostDisplayWatch* watch = watching.exchange(nullptr);
  if (watch == nullptr) return;
  if (watch->on_lost_) watch->on_lost_();
  const std::string line = watch->program_ + ": the display is gone; was its X server ended?\n";
  [[maybe_unused]] const ssize_t told = write(STDERR_FILENO, line.data(), line.size());
  // Nothing is tidied up: the display's libraries would need it for that.
  _exit(static_cast<int>(ErrorCode::Machine));
}

bool has_display() {
  const char* name = std::getenv("DISPLAY");
  if (name == nullptr || *name == '\0') return false;
  ::Display* display = XOpenDisplay(nullptr);
  if (display == nullptr) return false;
  // A server may reset when its last client leaves, and turn the next one away while it does.
  static ::Display* const held = display;
  if (display != held) XCloseDisplay(display);
  return true;
}

Display::Display() {
  if (has_display()) return;
  std::array<int, 2> pipe_ends{};
  if (pipe(pipe_ends.data()) != 0) throw Error(ErrorCode::Machine, "no pipe can be opened");
  const pid_t parent = getpid();
  server_ = fork();
  if (server_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);
    close(pipe_ends[0]);
    setpgid(0, 0);  // what is typed at the terminal is for us
    const int nowhere = open("/dev/null", O_RDWR);
    dup2(nowhere, STDIN_FILENO);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    const std::string to = std::to_string(pipe_ends[1]);
    execlp("Xvfb", "Xvfb", "-displayfd", to.c_str(), "-screen", "0", "1280x1024x24", "-nolisten",
           "tcp", "-noreset", static_cast<char*>(nullptr));
    _exit(127);
  }
  close(pipe_ends[1]);
  const std::string number = server_ > 0 ? read_line(pipe_ends[0]) : "";
  close(pipe_ends[0]);
  if (number.empty()) {
    if (server_ > 0) {
      kill(server_, SIGKILL);
      waitpid(server_, nullptr, 0);
      server_ = -1;
    }
    throw Error(ErrorCode::Machine,
                "there is no display to draw on and Xvfb does not start; install xvfb, or set "
                "DISPLAY");
  }
  setenv("DISPLAY", (":" + number).c_str(), 1);
}

Display::~Display() {
  if (server_ <= 0) return;
  kill(server_, SIGTERM);
  while (waitpid(server_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace beatlas::viewer
