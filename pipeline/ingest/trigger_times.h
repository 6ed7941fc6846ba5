#pragma once
#include <optional>
#include <string>
#include <vector>

#include "pipeline/ingest/slice_timing.h"

namespace beatlas::ingest {

/// What came of looking at trigger times.
struct TriggerReading {
  std::optional<SliceTiming> timing;  ///< if they can be believed
  std::string why_not;                ///< else: a clause
  bool many_beats = false;
};

/// @param printed_s the R-R interval that the images print, 0 if they do not
/// @param given_s of the user, 0 if it is not known; only tells several beats where nothing else
/// does
[[nodiscard]] TriggerReading read_triggers(const std::vector<FrameStamp>& stamps, double printed_s,
                                           double given_s);

inline constexpr double kRoundingMs = 0.51;  ///< times are printed in whole milliseconds
/// Times that cover less of the R-R interval are not a cine's, or are in other units.
inline constexpr double kLeastOfRr = 0.35;
inline constexpr double kSeveralBeats = 1.8;    ///< R-R intervals: more than one beat
inline constexpr std::size_t kLeastOfBeat = 4;  ///< frames of the first of several beats

/// Whether an R-R interval is one of a living heart.
[[nodiscard]] inline bool plausible_rr(double rr_s) {
  return rr_s >= kLeastRrS && rr_s <= kMostRrS;
}

/// Whether frames of a cine may be this far apart.
[[nodiscard]] inline bool ordinary_step(double ms) { return ms >= 10 && ms <= 150; }

}  // namespace beatlas::ingest
