#include "runtime/base/interrupts.h"

#include <ctime>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas {
namespace {

sigset_t ours() noexcept {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

// As if nobody had listened.
void end_by(int number) noexcept {
  std::signal(number, SIG_DFL);
  const sigset_t set = ours();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
  (void)std::raise(number);
}

}  // namespace

Interrupts::Interrupts(std::function<void()> wanted) {
  const sigset_t set = ours();
  pthread_sigmask(SIG_BLOCK, &set, &before_);
  thread_ = std::jthread([this, set, wanted = std::move(wanted)](const std::stop_token& stop) {
    constexpr timespec kLook{.tv_sec = 0, .tv_nsec = 50'000'000};
    while (!stop.stop_requested()) {
      const int number = sigtimedwait(&set, nullptr, &kLook);
      if (number <= 0) continue;
      if (came_.exchange(true)) end_by(number);
      wanted();
    }
  });
}

Interrupts::~Interrupts() {
  thread_.request_stop();
  thread_.join();
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void Interrupts::check() const {
  if (!came_) return;
  throw Error(ErrorCode::Machine,
              "interrupted; the force is off, the device is closed, and what was asked for is "
              "written as far as it came");
}

}  // namespace beatlas
