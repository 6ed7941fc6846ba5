#pragma once
/// What the images say along a surface: is there an edge, does it move, is there tissue under it.

#include <vector>

#include "pipeline/alarm/surface_points.h"
#include "pipeline/core/shapes.h"
#include "pipeline/tissue/tissue.h"

namespace beatlas::alarm {

/// Levels of the images that evidence is judged by.
struct EvidenceLevels {
  double blood = 0;   ///< of the labels' blood; 0 = none labelled
  double muscle = 0;  ///< of the LV's muscle; 0 = none labelled
  /// Blood above muscle; where either is missing, half of what the images span.
  double contrast = 0;
};

/// Medians over all phases. @param labels on the images' grid
[[nodiscard]] EvidenceLevels evidence_levels(const ImageCycle<float>& images,
                                             const ImageCycle<std::uint8_t>& labels);

/// Of each point of a surface in one phase, each averaged over some millimetres around it.
struct SurfaceEvidence {
  std::vector<float> step;   ///< between the levels on both sides, nearest edge within 1.5 mm
  std::vector<float> inner;  ///< level 2 to 3 mm inside
  std::vector<float> outer;  ///< level as far outside
  std::vector<float> swing;  ///< through the cycle, root mean square within 3 mm across the surface
};

/// @param image one phase, lightly smoothed in plane; @param noise of the images before that
[[nodiscard]] SurfaceEvidence surface_evidence(const Grid& grid, const std::vector<float>& image,
                                               const std::vector<float>& swing, double noise,
                                               const std::vector<SurfacePoint>& points);

/// [mm] Gaussian by which images are smoothed before surface_evidence.
[[nodiscard]] double evidence_sigma_mm(const Grid& grid);

}  // namespace beatlas::alarm
