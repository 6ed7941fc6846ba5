/// start_bench PACKAGE [REPEATS] [MOST_MB]: how long a trainer that lets a finger feel the heart
/// takes from nothing to its first force, and what memory it then has. Each run is a process of its
/// own that opens the package (which checks size and hash of what is read), makes the servo and
/// presses 3 mm into the heart. Cold: the package's pages are dropped from the system's cache
/// before each run; programs and libraries stay in it. Ends with status 1 if a run has more than
/// MOST_MB of resident memory.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"
#include "runtime/haptics/servo.h"

namespace beatlas {
namespace {

using Clock = std::chrono::steady_clock;

double resident_mb() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    if (word != "VmRSS:") continue;
    double kib = 0;
    status >> kib;
    return kib / 1024;
  }
  return 0;
}

/// What a run tells: the time is counted from `start`, before the package's name is looked at.
int first_force(const char* file, Clock::time_point start) {
  const atlas::Atlas package =
      atlas::Atlas::open(file, {.fields = {Structure::Heart}, .surfaces = {}});
  const auto heart = std::make_shared<const field::FieldQuery>(package.field(Structure::Heart),
                                                               package.manifest().rr_interval_s);
  haptics::Servo servo(
      haptics::proxy_scene(heart, {.stiffness_n_per_m = package.manifest().stiffness_n_per_m}), {});
  // From outside along x until the surface is 3 mm above.
  Vec3 at = heart->centre_mm() + Vec3(150, 0, 0);
  int ticks = 0;
  double opened_ms = 0;
  for (; ticks < 20000; ++ticks) {
    const haptics::Tick felt =
        servo.tick({.time_s = ticks / 1000.0, .position_mm = at, .valid = true});
    if (ticks == 0) {
      opened_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    }
    if (felt.force_n.norm() > 0) break;
    at.x() -= 0.1;
  }
  const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  const double cpu_ms = 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  std::printf("%.3f %.3f %.3f %.2f\n", opened_ms, ms, cpu_ms, resident_mb());
  return ticks < 20000 ? 0 : 1;
}

bool drop_from_cache(const char* file) {
  const int handle = ::open(file, O_RDONLY | O_CLOEXEC);
  if (handle < 0) return false;
  const bool dropped =
      ::fsync(handle) == 0 && ::posix_fadvise(handle, 0, 0, POSIX_FADV_DONTNEED) == 0;
  ::close(handle);
  return dropped;
}

struct Run {
  double first_tick_ms = 0;
  double first_force_ms = 0;
  double cpu_ms = 0;  ///< of all the process has done, loading of its libraries included
  double resident_mb = 0;
};

Run run_once(const char* program, const char* file) {
  const std::string command = std::string("'") + program + "' --once '" + file + "'";
  FILE* pipe = ::popen(command.c_str(), "r");
  Run out;
  const bool told =
      pipe != nullptr && std::fscanf(pipe, "%lf %lf %lf %lf", &out.first_tick_ms,
                                     &out.first_force_ms, &out.cpu_ms, &out.resident_mb) == 4;
  if (pipe == nullptr || ::pclose(pipe) != 0 || !told) throw_invalid("a run gave no force");
  return out;
}

int measure(const char* program, const char* file, int repeats, double most_mb) {
  std::printf("| %-4s | %12s | %12s | %13s | %10s | %8s |\n|---|---|---|---|---|---|\n", "ms",
              "1st tick p50", "1st tick max", "1st force max", "CPU, least", "MB, most");
  double most = 0;
  for (const bool cold : {false, true}) {
    std::vector<Run> runs;
    for (int n = 0; n < repeats; ++n) {
      if (cold && !drop_from_cache(file)) throw_invalid("cannot be dropped from the cache");
      runs.push_back(run_once(program, file));
    }
    std::sort(runs.begin(), runs.end(),
              [](const Run& a, const Run& b) { return a.first_tick_ms < b.first_tick_ms; });
    double force_ms = 0;
    double cpu_ms = 1e300;
    double mb = 0;
    for (const Run& run : runs) {
      force_ms = std::max(force_ms, run.first_force_ms);
      cpu_ms = std::min(cpu_ms, run.cpu_ms);
      mb = std::max(mb, run.resident_mb);
    }
    most = std::max(most, mb);
    std::printf("| %-4s | %12.2f | %12.2f | %13.2f | %10.2f | %8.1f |\n", cold ? "cold" : "warm",
                runs[runs.size() / 2].first_tick_ms, runs.back().first_tick_ms, force_ms, cpu_ms,
                mb);
  }
  if (most <= most_mb) return 0;
  std::printf("resident memory of %.1f MB is more than %.1f\n", most, most_mb);
  return 1;
}

}  // namespace
}  // namespace beatlas

int main(int argc, char** argv) {
  const auto start = std::chrono::steady_clock::now();
  if (argc < 2) {
    std::cerr << "start_bench PACKAGE [REPEATS] [MOST_MB]\n";
    return 2;
  }
  try {
    if (argc == 3 && std::string(argv[1]) == "--once") {
      return beatlas::first_force(argv[2], start);
    }
    return beatlas::measure(argv[0], argv[1], argc > 2 ? std::max(1, std::atoi(argv[2])) : 20,
                            argc > 3 ? std::atof(argv[3]) : 1e9);
  } catch (const beatlas::Error& error) {
    std::cerr << "start_bench: " << error.what() << '\n';
    return static_cast<int>(error.code());
  }
}
