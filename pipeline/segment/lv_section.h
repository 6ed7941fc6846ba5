#pragma once
/// The shape of the LV in a slice, where images alone tell it wrong.

#include <cstdint>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/segment/competition.h"

namespace beatlas::segment {

/// Papillary muscles and trabeculae count as cavity, as experts draw it (Schulz-Menger 2020,
/// doi:10.1186/s12968-020-00610-6): within a slice the cavity is convex, as far as its own wall
/// goes.
/// Papillary muscles that stand against the wall are no part of its hull, but of the ellipse that
/// fits that.
/// @param sure labels, [phase][voxel]; muscle there stays muscle
void fill_cavity(const LabelImages& sure, ImageCycle<std::uint8_t>& labels);

/// Whether muscle closes about the LV's cavity in a slice.
[[nodiscard]] bool is_closed(const ImageCycle<std::uint8_t>& labels, std::size_t phase, int k);

/// The wall has no hole below the base: in slices on the apical side of one that is closed, what
/// lies beside the cavity and is no muscle is the wall, 2 mm thick. Of slices that lie across the
/// LV.
/// @param base_step 1 or -1: the way along the slices to the base
void close_wall(int base_step, ImageCycle<std::uint8_t>& labels);

/// Cavity and wall together are a broad body: muscle of strips that hang on it and are narrower
/// than half of it, as broad as it is about its middle, is of another organ (the stomach's wall
/// lies against the heart and is as dark) and becomes background.
void trim_wall(ImageCycle<std::uint8_t>& labels);

/// Distance [mm] of each voxel to the cavity's outline in the plane of its slice, negative inside;
/// kNoDistance in slices without. What muscle the cavity holds (papillary muscles) belongs to it.
/// @param labels of one phase
[[nodiscard]] std::vector<float> distance_from_cavity(const Grid& grid,
                                                      std::vector<std::uint8_t> labels);

}  // namespace beatlas::segment
