#pragma once
/// What hangs together: a heart is one body, a ventricle one cavity.

#include <cstdint>
#include <vector>

#include "pipeline/core/exam.h"

namespace beatlas::segment {

/// Keeps what hangs together with the heart's largest part, through space and time, and of that in
/// each phase the largest part: what touches the heart in another phase alone is another body.
void keep_connected_heart(ImageCycle<std::uint8_t>& labels);

/// The same of these labels together; what does not hang together with them gets `instead`.
void keep_one_body(const std::vector<std::uint8_t>& of_labels, std::uint8_t instead,
                   ImageCycle<std::uint8_t>& labels);

/// Of these labels together, what does not hang together with their largest part, through space and
/// time, gets `instead`.
void keep_largest(const std::vector<std::uint8_t>& of_labels, std::uint8_t instead,
                  ImageCycle<std::uint8_t>& labels);

/// The same in each slice for itself, through time, and of what is left in each phase the largest
/// piece: a plane cuts a ventricle in one.
void keep_largest_of_each_slice(const std::vector<std::uint8_t>& of_labels, std::uint8_t instead,
                                ImageCycle<std::uint8_t>& labels);

/// What hangs together, through space and time, of all that is not 0 becomes 0 where a voxel of it
/// is `marked`.
void clear_marked_parts(std::uint8_t marked, ImageCycle<std::uint8_t>& image);

/// A ventricle's sections lie over each other: of each piece of a slice, through time, at least a
/// quarter lies over the cavity in the slice before it, counted from the slice whose sections have
/// most wall about them, and in a phase that leaves slices out the sections on their side with most
/// wall count, unless the wall closed upon the cavity there, as in the middle of a thick-walled
/// ventricle at end-systole; the others get `instead`.
void keep_stacked(std::uint8_t cavity, std::uint8_t wall, std::uint8_t instead,
                  ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
