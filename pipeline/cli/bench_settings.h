#pragma once
/// What the files of BenchRunner share: settings as stages read them, and clocked values.

#include <array>
#include <string>
#include <vector>

#include "pipeline/cli/bench_probe.h"
#include "pipeline/cli/bench_runner.h"

namespace beatlas::cli {

/// In the order in which they run; the sections of the settings.
inline constexpr std::array kBenchStages{"phantom", "segment", "register", "field",
                                         "mesh",    "level",   "pack",     "query"};
inline const std::vector<Structure> kBenchStructures{Structure::Heart, Structure::LvBlood,
                                                     Structure::RvBlood};

/// What a stage and those before it obey, as a key.
[[nodiscard]] std::string key_of(const nlohmann::json& settings, const std::string& stage);
[[nodiscard]] build::Recipe recipe_of_settings(nlohmann::json settings);
[[nodiscard]] phantom::PhantomSpec spec_of(phantom::PhantomSpec spec,
                                           const nlohmann::json& settings);

/// make() with what it cost.
template <class Make>
[[nodiscard]] auto timed(const Make& make) {
  const MemoryMeter memory;
  const double start = wall_clock_s();
  using Value = decltype(make());
  Timed<Value> out;
  out.value = std::make_shared<const Value>(make());
  out.wall_s = wall_clock_s() - start;
  out.memory_mb = memory.added_mb();
  return out;
}

}  // namespace beatlas::cli
