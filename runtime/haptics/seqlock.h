#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace beatlas::haptics {

/// One writer that never waits, any number of readers that retry while it writes (Boehm, "Can
/// seqlocks get along with programming language memory models?", 2012). Every word is an atomic:
/// the writer's are releases, so that a reader that has seen one of a newer value also sees that
/// the count has moved on; no fence is needed.
template <class T>
class Seqlock {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Seqlock() noexcept { write(T{}); }

  void write(const T& value) noexcept {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    const std::uint64_t count = count_.load(std::memory_order_relaxed);
    count_.store(count + 1, std::memory_order_relaxed);
    for (std::size_t n = 0; n < kWords; ++n) words_[n].store(words[n], std::memory_order_release);
    count_.store(count + 2, std::memory_order_release);
  }

  /// The newest value as a whole.
  [[nodiscard]] T read() const noexcept {
    T value;
    while (!try_read(value)) {
    }
    return value;
  }

  /// The same for a reader that must not wait, as a servo: false where it is being written, and
  /// `value` stays as it was.
  [[nodiscard]] bool try_read(T& value) const noexcept {
    const std::uint64_t before = count_.load(std::memory_order_acquire);
    std::array<std::uint64_t, kWords> words;
    for (std::size_t n = 0; n < kWords; ++n) words[n] = words_[n].load(std::memory_order_acquire);
    if (before % 2 != 0 || count_.load(std::memory_order_relaxed) != before) return false;
    std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
    return true;
  }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;
  std::atomic<std::uint64_t> count_{0};
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace beatlas::haptics
