#pragma once
/// From the competition's raw labels to anatomy: papillary muscles into the cavity, a wall of
/// plausible thickness, the RV's wall, one connected heart.

#include "pipeline/segment/chambers.h"
#include "pipeline/segment/seeds.h"

namespace beatlas::segment {

/// Works slice by slice on one phase of labels (see atlas Label), in place.
void tidy_phase(const Grid& grid, const std::vector<float>& image, const Chambers& chambers,
                int phase, std::vector<std::uint8_t>& labels);

/// Smooths the surfaces of cavities, LV wall and heart: Gaussian of their signed distance in plane,
/// 1-2-1 over neighbouring phases (from five phases on).
void smooth_in_time_and_plane(ImageCycle<std::uint8_t>& labels, double sigma_mm);

/// Keeps in each phase what hangs together with the heart's largest part, through space and time.
void keep_connected_heart(ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
