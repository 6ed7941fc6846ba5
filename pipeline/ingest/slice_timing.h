#pragma once
/// When the images of one slice were taken, as a share of the R-R interval.

#include <optional>
#include <string>
#include <vector>

namespace beatlas::ingest {

/// What one image says about its time. Scanners fill these fields with varying care.
struct FrameStamp {
  std::optional<double> trigger_ms = {};         ///< after the R wave
  std::optional<double> rr_ms = {};              ///< of its slice
  std::optional<double> elapsed_ms = {};         ///< since the first frame (FrameTimeVector)
  std::optional<double> frame_time_ms = {};      ///< between frames
  std::optional<double> temporal_position = {};  ///< order
  std::optional<double> acquisition_s = {};      ///< of the day
  std::optional<double> content_s = {};          ///< of the day
  std::optional<double> instance = {};           ///< order
  std::optional<double> acquisition_number = {};
};

/// The frames of one slice in the order of the cycle.
struct SliceTiming {
  std::vector<int> order;      ///< index into the stamps, one a frame, ascending in time
  std::vector<double> time_s;  ///< one a frame: recorded times, or made up from the order
  double rr_s = 0;             ///< R-R interval of this slice; 0 if nothing tells it
  bool timed = false;          ///< time_s are recorded times, not an even spread
  bool by_trigger = false;     ///< they are trigger times
  bool beat_unknown = false;   ///< several beats, and nothing tells how long one is: no cine yet
  bool many_beats = false;     ///< about one image a beat: perfusion, not a cine
  std::string source;          ///< the attribute that gives time or order
  std::string note;            ///< what was odd, a clause without a full stop; may be empty
};

/// Plausible R-R intervals [s]: 20 to 300 beats a minute.
inline constexpr double kLeastRrS = 0.2;
inline constexpr double kMostRrS = 3.0;

/// Orders the images of a slice.
/// - Trigger times are believed if they differ and lie within an R-R interval, in ms or, if they
///   fit only then, in seconds, tenths of a millisecond or microseconds. Of images that share a
///   trigger time the first is kept. Times in ms that step as frames of a cine do (10 to 150 ms)
///   are in ms, however many beats they span. Of several beats, told by times that start again or
///   go on for 1.8 R-R intervals and more, the first is kept; so it is of other recorded times.
///   Times that step by whole beats are no times of a cine.
/// - Else FrameTimeVector gives the times; else the order is that of TemporalPosition, then of
///   AcquisitionTime and ContentTime if they step evenly within a beat in the order of
///   InstanceNumber or its reverse, then of InstanceNumber, in steps of FrameTime if they fit the
///   R-R interval, else evenly over it.
/// - The R-R interval is NominalInterval (or HeartRate); where recorded times contradict it, or it
///   is absent, frames x mean step. NominalInterval is printed in whole ms: even steps that agree
///   with it to rounding give the finer value.
/// @return nothing if the images have no order at all, or are fewer than two.
/// @param given_rr_s how long a beat is if the images do not print it; 0: not known
[[nodiscard]] std::optional<SliceTiming> time_slice(const std::vector<FrameStamp>& stamps,
                                                    double given_rr_s = 0);

/// Replaces the times of a slice's frames. R-R: `rr_s` if it is given, else the slice's own if the
/// times lie within it, else frames x mean step.
/// @param times_s ascending, as many as the slice has frames
[[nodiscard]] SliceTiming with_times(SliceTiming timing, const std::vector<double>& times_s,
                                     double rr_s);

/// Replaces the R-R interval of a slice. Times made up from the order stretch with it, and so do
/// recorded ones that fill the slice's own interval evenly: retrospective gating makes them shares
/// of it. Others stay as recorded.
/// @return nothing if those do not lie within the interval
[[nodiscard]] std::optional<SliceTiming> with_rr(SliceTiming timing, double rr_s);

/// The phase of every frame, in [0, 1), in the order of timing.order (so it may wrap once).
/// Evenly spaced times, printed in whole ms, are taken as even.
/// @param rr_s used where timing.rr_s is 0 and the times are recorded ones; > 0
[[nodiscard]] std::vector<double> phases_of(const SliceTiming& timing, double rr_s);

/// The largest distance between neighbouring phases around the cycle, 0..1; 1 for one phase.
[[nodiscard]] double largest_gap(std::vector<double> phases);

/// The share of the cycle of which there is no frame: what the largest gap has beyond the mean of
/// the other steps. 0 unless it is at least 1.5 times that.
[[nodiscard]] double unseen_share(const std::vector<double>& phases);

}  // namespace beatlas::ingest
