#pragma once
/// Clefts of the heart, between ventricles, atria and vessels.

#include <cstdint>
#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/edges/layer_fit.h"

namespace beatlas::edges {

inline constexpr double kLungShare = 0.5;  ///< of muscle's level, the brightest lung

/// Fat and lung fill the grooves between ventricles, atria and vessels and reach far between them,
/// where labels that grew from all sides took them for the heart. What is as bright as fat or as
/// dark as lung and hangs together with the like outside becomes background, and so does the film
/// between the two. Fat has to be brighter than blood.
/// @param labels one phase, changed in place  @param image of the same grid and phase
void let_others_in(const Grid& grid, const std::vector<float>& image, const LayerLevels& levels,
                   std::vector<std::uint8_t>& labels);

}  // namespace beatlas::edges
