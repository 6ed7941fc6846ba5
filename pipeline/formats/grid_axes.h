#pragma once
/// What every format's geometry must pass: axes at right angles, sizes that can be.

#include <string>

#include "runtime/base/geometry.h"

namespace beatlas::formats {

/// Edges of a voxel and its place, as headers may name them [mm].
inline constexpr double kLeastEdgeMm = 1e-3;
inline constexpr double kMostEdgeMm = 1e3;
inline constexpr double kMostPlaceMm = 1e5;
/// Cosine between two axes from which a grid counts as sheared, one degree.
inline constexpr double kShear = 0.02;
/// From this cosine on (what five digits in a header leave) axes are repaired, and it is told.
inline constexpr double kSkew = 2e-5;

[[nodiscard]] bool usable_edges(const Vec3& edges_mm);

void add_sentence(std::string& note, const std::string& sentence);

/// `mm_from_index` with axes at right angles: the nearest such axes of the same lengths where they
/// are off by little (then told in `note`), exactly as it was where they are off by less.
/// @throws Error{InvalidInput} if an edge or the place cannot be, or the grid is sheared
[[nodiscard]] Affine checked_axes(const Affine& mm_from_index, std::string& note);

}  // namespace beatlas::formats
