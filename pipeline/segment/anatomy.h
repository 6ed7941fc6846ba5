#pragma once
/// From the competition's raw labels to anatomy: papillary muscles into the cavity, a wall of
/// plausible thickness, the RV's wall, one connected heart.

#include "pipeline/segment/chambers.h"
#include "pipeline/segment/seeds.h"

namespace beatlas::segment {

/// Works slice by slice on one phase of labels (see atlas Label), in place.
/// @param drawn marks of a technician in this phase, kUnlabelled elsewhere. What is
/// marked as LV blood is cavity however dark it is, a papillary muscle say, and with it what lies
/// between it and the pool.
void tidy_phase(const Grid& grid, const std::vector<float>& image, const Chambers& chambers,
                int phase, const std::vector<std::uint8_t>& drawn,
                std::vector<std::uint8_t>& labels);

/// What went into smooth_outlines another time, and what came out; null: nothing.
struct SmoothedBefore {
  const LabelImages* in = nullptr;
  const LabelImages* out = nullptr;
};

/// Smooths the outlines of cavities, LV wall and heart in each slice: Gaussian of their signed
/// distance. Not over phases: early filling bends a wall's path by millimetres between two phases.
/// @param known labels in the same box teach the outlines of all phases, see known_outlines.h
/// @param before of a run with the same sigma and nothing known: slices that went in then as they
/// do now come out as they did
void smooth_outlines(ImageCycle<std::uint8_t>& labels, double sigma_mm,
                     const KnownLabels& known = {}, const SmoothedBefore& before = {});

}  // namespace beatlas::segment
