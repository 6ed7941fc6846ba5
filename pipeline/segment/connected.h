#pragma once
/// What hangs together: a heart is one body, a ventricle one cavity.

#include <cstdint>
#include <vector>

#include "pipeline/core/exam.h"

namespace beatlas::segment {

/// Keeps in each phase what hangs together with the heart's largest part, through space and time.
void keep_connected_heart(ImageCycle<std::uint8_t>& labels);

/// Of these labels together, what does not hang together with their largest part, through space and
/// time, gets `instead`.
void keep_largest(const std::vector<std::uint8_t>& of_labels, std::uint8_t instead,
                  ImageCycle<std::uint8_t>& labels);

/// The same in each slice of each phase for itself: a plane cuts a ventricle in one piece.
void keep_largest_of_each_slice(const std::vector<std::uint8_t>& of_labels, std::uint8_t instead,
                                ImageCycle<std::uint8_t>& labels);

/// The same of one label in each phase for itself.
void keep_largest_of_each_phase(std::uint8_t label, std::uint8_t instead,
                                ImageCycle<std::uint8_t>& labels);

/// A ventricle empties within the place that it fills at its fullest: of what a slice of a phase
/// has of a cavity in one piece, at least half lies where cavity or wall are in the phase in which
/// the cavity is largest, or it gets `instead`.
void keep_within_fullest(std::uint8_t cavity, std::uint8_t wall, std::uint8_t instead,
                         ImageCycle<std::uint8_t>& labels);

/// Of a cavity each phase keeps the part that has most of its wall about it in the plane of slices
/// (an atrium that was taken for ventricle may be the larger one at end-systole), and those of
/// whose outline at least half is wall: where slices lie far apart, a cavity need not overlap with
/// itself. Half is what experts ask of a basal slice (Schulz-Menger 2020,
/// doi:10.1186/s12968-020-00610-6).
void keep_cavity_of_each_phase(std::uint8_t cavity, std::uint8_t wall, std::uint8_t instead,
                               ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
