#pragma once
/// Common phases from the frames of a slice.

#include <array>
#include <vector>

namespace beatlas::ingest {

/// A common phase as a weighted sum of at most four frames.
struct PhaseTaps {
  std::array<int, 4> frame{};
  std::array<double, 4> weight{};
  int count = 0;
};

/// Fewer frames a cycle than this are not blended.
inline constexpr int kLeastFramesToBlend = 8;
/// A frame this near to a common phase, in frame intervals, is copied.
inline constexpr double kSamePhase = 1e-3;

/// The taps of phases 0, 1/count, ... (count - 1)/count.
/// With kLeastFramesToBlend frames or more: the periodic cubic Hermite spline through the frames
/// with slopes from their neighbours (Catmull-Rom on uneven knots); weights sum to 1. With fewer:
/// as many phases as frames take the frames in order, turned so that they fit best; otherwise each
/// phase takes the nearest frame.
/// @param phases of the frames, in [0, 1), all different, any order; at least one
[[nodiscard]] std::vector<PhaseTaps> resample_phases(const std::vector<double>& phases, int count);

/// The weighted sum of `frames[tap]`, all of one size, written to `out`, which has room for one.
void blend_to(const std::vector<std::vector<float>>& frames, const PhaseTaps& taps, float* out);

}  // namespace beatlas::ingest
