#include "runtime/viewer/tick_times.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace beatlas::viewer {
namespace {

constexpr double kLeastNs = 64;
constexpr double kAnOctave = 12;

}  // namespace

std::int64_t clock_ns() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void TickTimes::add(std::int64_t ns) noexcept {
  const double octaves = std::log2(std::max(kLeastNs, static_cast<double>(ns)) / kLeastNs);
  const int step = std::min(kSteps - 1, static_cast<int>(kAnOctave * octaves));
  counts_[static_cast<std::size_t>(step)].fetch_add(1, std::memory_order_relaxed);
}

void TickTimes::clear() noexcept {
  for (auto& count : counts_) count.store(0, std::memory_order_relaxed);
}

std::uint64_t TickTimes::count() const noexcept {
  std::uint64_t all = 0;
  for (const auto& count : counts_) all += count.load(std::memory_order_relaxed);
  return all;
}

double TickTimes::quantile_us(double share) const noexcept {
  const std::uint64_t all = count();
  if (all == 0) return 0;
  const double rank = std::max(1.0, std::ceil(share * static_cast<double>(all)));
  std::uint64_t seen = 0;
  int step = 0;
  for (; step < kSteps - 1; ++step) {
    seen += counts_[static_cast<std::size_t>(step)].load(std::memory_order_relaxed);
    if (static_cast<double>(seen) >= rank) break;
  }
  return 1e-3 * kLeastNs * std::exp2((step + 1) / kAnOctave);
}

}  // namespace beatlas::viewer
