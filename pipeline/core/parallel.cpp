#include "pipeline/core/parallel.h"

#include <atomic>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

namespace beatlas {
namespace {

std::atomic<const std::atomic<bool>*> stop_flag{nullptr};

}  // namespace

void set_stop_flag(const std::atomic<bool>* flag) { stop_flag = flag; }

void check_stop_flag() {
  StageContext stop;
  stop.cancel = stop_flag;
  stop.check_cancelled();
}

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  std::vector<std::exception_ptr> failures(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    try {
      check_stop_flag();
      body(i);
    } catch (...) {
      failures[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

void parallel_for(std::size_t count, const StageContext& context, std::string_view what,
                  const std::function<void(std::size_t)>& body) {
  std::atomic<std::size_t> begun{0};
  parallel_for(count, [&](std::size_t i) {
    context.check_cancelled();
    const std::size_t at = begun++;
    context.progress(
        static_cast<double>(at) / static_cast<double>(count),
        std::string(what) + " " + std::to_string(at + 1) + " of " + std::to_string(count));
    body(i);
  });
}

void set_thread_count(int threads) {
  static std::unique_ptr<tbb::global_control> control;
  control.reset();
  if (threads > 0) {
    control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<std::size_t>(threads));
  }
}

}  // namespace beatlas
