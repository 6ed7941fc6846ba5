#pragma once
/// SIGINT and SIGTERM as a wish to end, for programs that hold a device: the force must be off and
/// the device closed before the process is gone.

#include <atomic>
#include <csignal>
#include <functional>
#include <thread>

namespace beatlas {

/// While it lives these signals end nothing by themselves. Made before the threads that are to go
/// on undisturbed, since threads and programs begun meanwhile inherit its mask; one at a time.
class Interrupts {
 public:
  /// @param wanted called once, at the first signal, on a thread of its own: may lock and allocate.
  /// The second signal ends the process at once.
  explicit Interrupts(std::function<void()> wanted);
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;

  [[nodiscard]] bool came() const noexcept { return came_; }
  /// @throws Error{Machine} if one came: force off, device closed
  void check() const;

 private:
  sigset_t before_{};
  std::atomic<bool> came_{false};
  std::jthread thread_;
};

}  // namespace beatlas
