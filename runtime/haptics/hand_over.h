#pragma once
#include <atomic>
#include <memory>

namespace beatlas::haptics {

/// Gives a servo's thread, which neither waits nor frees, another value to use. What it no longer
/// uses is freed by the caller's thread: at its next offer, by `collect`, or with this.
template <class T>
class HandOver {
 public:
  HandOver() = default;
  ~HandOver() {
    delete offered_.load();
    delete retired_.load();
  }
  HandOver(const HandOver&) = delete;
  HandOver& operator=(const HandOver&) = delete;

  // The caller's thread.
  /// An offer that was not taken up yet is replaced.
  void offer(std::unique_ptr<T> fresh) noexcept {
    delete offered_.exchange(fresh.release(), std::memory_order_acq_rel);
    // Afterwards: what the servo retired to take up the offer before would keep it from this one.
    collect();
  }
  void collect() noexcept { delete retired_.exchange(nullptr, std::memory_order_acq_rel); }

  // The servo's thread.
  /// Puts what was offered in the place of `held`; false if there is nothing new, or if what was
  /// retired last has still to be collected, which the next offer does.
  [[nodiscard]] bool take_up(std::unique_ptr<T>& held) noexcept {
    return take_up(held, [](const T&, T&) noexcept {});
  }
  /// The same; `carry(held, fresh)` first, while nobody may free either.
  template <class Carry>
  [[nodiscard]] bool take_up(std::unique_ptr<T>& held, const Carry& carry) noexcept {
    if (offered_.load(std::memory_order_relaxed) == nullptr ||
        retired_.load(std::memory_order_acquire) != nullptr) {
      return false;
    }
    T* const fresh = offered_.exchange(nullptr, std::memory_order_acq_rel);
    if (fresh == nullptr) return false;
    carry(static_cast<const T&>(*held), *fresh);
    retired_.store(held.release(), std::memory_order_release);
    held.reset(fresh);
    return true;
  }

 private:
  std::atomic<T*> offered_{nullptr};
  std::atomic<T*> retired_{nullptr};
};

}  // namespace beatlas::haptics
