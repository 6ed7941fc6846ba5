#include "pipeline/cli/bench_probe.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <string>

#include <malloc.h>

namespace beatlas::cli {
namespace {

/// A line of /proc/self/status, which counts in kB.
std::optional<double> status_mb(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(key, 0) == 0) return std::stod(line.substr(key.size())) / 1024;
  }
  return {};
}

}  // namespace

MemoryMeter::MemoryMeter() {
  malloc_trim(0);
  std::ofstream reset("/proc/self/clear_refs");
  reset << "5" << std::flush;
  if (reset) before_mb_ = status_mb("VmRSS:");
}

std::optional<double> MemoryMeter::added_mb() const {
  const std::optional<double> highest = status_mb("VmHWM:");
  if (!before_mb_ || !highest) return {};
  return std::max(0.0, *highest - *before_mb_);
}

std::vector<Question> path_questions(const assess::TruthSet& truth,
                                     const Affine& workspace_from_lps, double rr_interval_s) {
  std::vector<Question> out;
  const assess::PalpationSet& set = truth.forces.set;
  for (const assess::Trajectory& path : set.trajectories) {
    for (std::size_t tick = 0; tick < path.at_lps.size(); ++tick) {
      out.push_back({workspace_from_lps * path.at_lps[tick],
                     static_cast<double>(tick) * rr_interval_s / set.ticks_per_beat});
    }
  }
  return out;
}

std::vector<Question> random_questions(const assess::TruthSet& truth,
                                       const Affine& workspace_from_lps, double rr_interval_s) {
  constexpr int kQuestions = 8192;
  constexpr double kAwayMm = 3;
  std::uint64_t state = 1;
  const auto uniform = [&state] {  // 0..1; Knuth's MMIX
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11U) * 0x1p-53;
  };
  std::vector<Question> out;
  const auto found = truth.surfaces.find(Structure::Heart);
  if (found == truth.surfaces.end() || found->second.empty()) return out;
  for (int n = 0; n < kQuestions; ++n) {
    const auto at = static_cast<std::size_t>(uniform() * static_cast<double>(found->second.size()));
    const assess::TruthPoint& point = found->second[at];
    const double away = kAwayMm * (2 * uniform() - 1);
    out.push_back(
        {workspace_from_lps * Vec3(point.lps + away * point.normal), uniform() * rr_interval_s});
  }
  return out;
}

double wall_clock_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double thread_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace beatlas::cli
