#pragma once
/// Work that takes a while, beside the window.

#include <chrono>
#include <exception>
#include <functional>
#include <future>
#include <optional>
#include <utility>

namespace beatlas::viewer {

/// One piece of work at a time; the newest wish counts: what was begun before is dropped when it
/// ends. Of one thread, which asks from time to time. Its end waits for the work that goes on.
template <class Result>
class Background {
 public:
  void begin(std::function<Result()> work) {
    if (now_.valid()) {
      unwanted_ = true;
      next_ = std::move(work);
    } else {
      now_ = std::async(std::launch::async, std::move(work));
    }
  }

  /// Something that is wanted goes on.
  [[nodiscard]] bool busy() const { return next_ || (now_.valid() && !unwanted_); }

  /// What the newest work made, once; nothing while it goes on. Throws what it threw.
  [[nodiscard]] std::optional<Result> take() {
    if (!now_.valid() || now_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
      return std::nullopt;
    }
    std::future<Result> ended = std::exchange(now_, {});
    if (!std::exchange(unwanted_, false)) return ended.get();
    try {
      (void)ended.get();
    } catch (const std::exception&) {
      // Nobody waits for it any more.
    }
    if (next_) begin(std::exchange(next_, nullptr));
    return std::nullopt;
  }

  /// What goes on is dropped when it ends.
  void drop() {
    unwanted_ = now_.valid();
    next_ = nullptr;
  }

 private:
  bool unwanted_ = false;
  std::future<Result> now_;
  std::function<Result()> next_;
};

}  // namespace beatlas::viewer
