#pragma once
/// What `beatlas bench` measured, and how it is told.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/assess/bench_plan.h"
#include "pipeline/assess/pareto.h"
#include "pipeline/assess/truth_set.h"
#include "runtime/atlas/structures.h"

namespace beatlas::assess {

/// How the images around the heart come back, near it.
struct VolumeErrors {
  double of_noise = 0;  ///< rms off images without noise, over that of the images that were packed
  double voxel_ns = 0;  ///< of wall time for a voxel at any moment of the beat
};

/// Figures of one run. Times are wall time on `BenchReport::threads` threads.
struct BenchRow {
  BenchRun run;
  std::map<Structure, SurfaceErrors> errors;
  std::optional<ForceErrors> force;    ///< of fields and paper A's voxels
  std::optional<VolumeErrors> volume;  ///< of a volume, which has no other errors
  std::map<std::string, double>
      stage_s;         ///< for the heart; segment and register for all structures
  double build_s = 0;  ///< of the stages that the knob concerns
  double total_s = 0;  ///< of all stages, others as in the default run
  std::size_t package_bytes = 0;
  double load_ms = 0;                     ///< median of opening the package
  std::optional<double> query_path_ns;    ///< along palpations at 1 kHz, median of repeats
  std::optional<double> query_random_ns;  ///< random points of the band at random times
  std::optional<double> peak_memory_mb;   ///< while its stages ran, above what was held before
  std::optional<int> draco_bits;          ///< of the heart's surface
  bool front_bytes = false;               ///< on the Pareto front of error and package bytes
  bool front_query = false;               ///< of error and query_path_ns
  bool front_build = false;               ///< of error and total_s
};

/// One size of a scaling series.
struct ScalingRow {
  std::string series;  ///< "voxels" or "phases"
  double size = 0;     ///< voxels of one image, or phases
  double factor = 0;   ///< voxels: times the preset's
  std::map<std::string, double> stage_s;
  double total_s = 0;
  std::size_t package_bytes = 0;
  std::optional<double> peak_memory_mb;
};

/// y over size of one series: "segment", ..., "total", "memory" or "bytes".
struct ScalingFit {
  std::string series;
  std::string what;
  PowerLaw law;
};

struct BenchReport {
  std::string preset;
  std::string version;
  bool quick = false;
  int repeats = 0;
  int threads = 0;
  int phases = 0;
  std::vector<BenchRow> rows;
  std::vector<ScalingRow> scaling;
  std::vector<ScalingFit> fits;
  double wall_s = 0;
};

/// Sets the marks front_*: among the rows of one sweep that pack fields (paper A's included), by
/// the heart's mean error. Rows of one setting are one point.
void mark_fronts(std::vector<BenchRow>& rows);

/// Exponents of every stage, the total, the memory and the bytes, of the series that have two
/// sizes.
[[nodiscard]] std::vector<ScalingFit> fit_scaling(const std::vector<ScalingRow>& rows);

/// schemas/bench.schema.json.
[[nodiscard]] nlohmann::json bench_to_json(const BenchReport& report);

/// A table a knob, each with what its errors may be compared with.
[[nodiscard]] std::string bench_to_markdown(const BenchReport& report);

/// "1.5" or "trilinear, linear": the values of a row's knob.
[[nodiscard]] std::string shown_values(const BenchRun& run);

}  // namespace beatlas::assess
