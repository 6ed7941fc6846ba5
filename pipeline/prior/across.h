#pragma once
/// Stacks of thin slices cut anew, across the left ventricle: there a wall is a ring in each slice,
/// where slices along it see it cut at a slant or not at all.

#include <optional>

#include "pipeline/prior/prior.h"
#include "pipeline/prior/slices.h"

namespace beatlas::prior {

/// A lattice across the LV's long axis, and the part of it that holds the heart.
struct AcrossLv {
  Grid grid;      ///< of images as fine as the stack's, half of neighbour_mm from slice to slice
  Window window;  ///< of network_grid(grid, ...)
};

/// The axis is that along which the LV's blood and wall, as they were seen, are longest.
/// @param looked at the whole of some phases; others may be empty
/// @return none if no LV was seen, slices are too far apart to be cut anew, or they lie across the
/// LV rather than along it as they are
[[nodiscard]] std::optional<AcrossLv> across_lv(const PriorCycle& looked, const Grid& stack,
                                                const ModelCard& card);

/// The images on another grid, linear in space; 0 beyond them.
[[nodiscard]] Cine cut_anew(const Cine& stack, const Grid& grid);

/// Puts the mean of both priors' probabilities where the second knows something.
/// @param across of the same phases and outputs; @param window of its grid that was looked at
void mix_in(const PriorCycle& across, const Window& window, PriorCycle& prior);

}  // namespace beatlas::prior
