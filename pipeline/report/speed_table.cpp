#include "pipeline/report/speed_table.h"

#include <array>
#include <cstdio>

namespace beatlas::report {
namespace {

std::string row(const std::string& stage, double wall_s, double cpu_s, double share) {
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), "%-10.24s %9.2f s %9.2f s %6.1f %%\n", stage.c_str(),
                wall_s, cpu_s, 100 * share);
  return text.data();
}

}  // namespace

std::string speed_table(const std::vector<StageTime>& stages, double peak_memory_mb) {
  StageTime total{"total", 0, 0};
  for (const StageTime& stage : stages) {
    total.wall_s += stage.wall_s;
    total.cpu_s += stage.cpu_s;
  }
  std::string table = "stage           wall         cpu      share\n";
  for (const StageTime& stage : stages) {
    table += row(stage.stage, stage.wall_s, stage.cpu_s,
                 total.wall_s > 0 ? stage.wall_s / total.wall_s : 0);
  }
  table += row(total.stage, total.wall_s, total.cpu_s, 1);
  std::array<char, 64> memory{};
  std::snprintf(memory.data(), memory.size(), "peak memory %.0f MB\n", peak_memory_mb);
  return table + memory.data();
}

}  // namespace beatlas::report
