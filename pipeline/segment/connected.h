#pragma once
/// What hangs together: a heart is one body, a ventricle one cavity.

#include <cstdint>
#include <vector>

#include "pipeline/core/exam.h"

namespace beatlas::segment {

/// Of each phase, voxels of the labels' grid.
using VoxelCycle = std::vector<std::vector<std::uint32_t>>;

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

/// Of the right ventricle's blood each phase keeps its largest part; the others are rest of heart:
/// fat as bright beyond its thin wall, and, where the outflow tract comes into a thick slice, blood
/// that no other slice joins to the ventricle yet.
/// @return the voxels of the others
VoxelCycle keep_connected_rv(ImageCycle<std::uint8_t>& labels);

/// The same in one phase.
std::vector<std::uint32_t> keep_connected_rv(const Grid& grid, std::vector<std::uint8_t>& labels);

/// Of these voxels, those of one label get another. @return those
VoxelCycle relabel(const VoxelCycle& voxels, std::uint8_t from, std::uint8_t to,
                   ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
