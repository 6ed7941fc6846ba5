#pragma once
/// When the images of one slice were taken, as a share of the R-R interval.

#include <optional>
#include <string>
#include <vector>

namespace beatlas::ingest {

/// What one image says about its time. Scanners fill these fields with varying care.
struct FrameStamp {
  std::optional<double> trigger_ms;         ///< after the R wave
  std::optional<double> rr_ms;              ///< of its slice
  std::optional<double> frame_time_ms;      ///< between frames
  std::optional<double> temporal_position;  ///< order
  std::optional<double> instance;           ///< order
};

/// The frames of one slice in the order of the cycle.
struct SliceTiming {
  std::vector<int> order;      ///< index into the stamps, one a frame, ascending in time
  std::vector<double> time_s;  ///< one a frame: trigger times, or made up from the order
  double rr_s = 0;             ///< R-R interval of this slice; 0 if nothing tells it
  bool by_trigger = false;     ///< time_s are the recorded trigger times
  std::string note;            ///< what was odd, a clause without a full stop; may be empty
};

/// Plausible R-R intervals [s]: 20 to 300 beats a minute.
inline constexpr double kLeastRrS = 0.2;
inline constexpr double kMostRrS = 3.0;

/// Orders the images of a slice.
/// - Trigger times are believed if they differ and span less than an R-R interval. Images that
///   share a trigger time with another (other contrasts) are left out, the first is kept.
/// - Else the order is that of TemporalPosition, else of InstanceNumber, frames evenly over the
///   R-R interval.
/// - The R-R interval is NominalInterval (or HeartRate); where trigger times contradict it, or it
///   is absent, frames x mean step. NominalInterval is printed in whole ms: even steps that agree
///   with it to rounding give the finer value.
/// @return nothing if the images have no order at all, or are fewer than two.
[[nodiscard]] std::optional<SliceTiming> time_slice(const std::vector<FrameStamp>& stamps);

/// The phase of every frame, in [0, 1), in the order of timing.order (so it may wrap once).
/// Evenly spaced trigger times, printed in whole ms, are taken as even.
/// @param rr_s used where timing.rr_s is 0 and the times are recorded ones; > 0
[[nodiscard]] std::vector<double> phases_of(const SliceTiming& timing, double rr_s);

/// The largest distance between neighbouring phases around the cycle, 0..1; 1 for one phase.
[[nodiscard]] double largest_gap(std::vector<double> phases);

}  // namespace beatlas::ingest
