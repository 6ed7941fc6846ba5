#pragma once
#include <string>
#include <vector>

namespace beatlas::report {

struct StageTime {
  std::string stage;
  double wall_s = 0;
  double cpu_s = 0;  ///< of all threads of the process
};

/// A plain-text table: stage, wall time, CPU time, share of the whole; then the peak memory.
[[nodiscard]] std::string speed_table(const std::vector<StageTime>& stages, double peak_memory_mb);

}  // namespace beatlas::report
