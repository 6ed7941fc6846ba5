#pragma once
/// The triangles of a structure's surface against a truth: of what is drawn and not felt, an atrium
/// or the aorta, of which a package has no field; and of all structures where the truth is a drawn
/// exam's, which knows no distances but where it is inside.

#include <functional>
#include <optional>
#include <vector>

#include "pipeline/assess/compare.h"
#include "pipeline/assess/figures.h"
#include "pipeline/core/grid.h"
#include "pipeline/phantom/drawn_truth.h"
#include "pipeline/phantom/phantom.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::assess {

/// A true surface in one phase, as far as one asks of it. LPS [mm].
struct TrueSurface {
  struct Point {
    Vec3 lps = Vec3::Zero();
    double area = 1;  ///< that it stands for, in any unit
  };
  std::vector<Point> points;
  /// [mm] From the true surface, + outside; none where nothing is asked.
  std::function<std::optional<double>(const Vec3& lps)> distance_mm;
};

/// Creases of the truth are left out. @param p 0 to `phases` - 1; stands for that share of the R-R
/// interval @pre the truth has such a part
[[nodiscard]] TrueSurface true_surface(const phantom::Phantom& truth, Structure structure, int p,
                                       int phases, const CompareOptions& options);

/// Of a drawn exam. Places are left out that lie more than half a voxel beyond the images, and of
/// the heart those beyond the LV's base. A distance is that from the plane of the nearest point of
/// frame.surface(structure), on the side that frame.contains tells. Stands while the frame does.
/// @param frame with a lattice of spacing_mm  @param seen grid of the images
[[nodiscard]] TrueSurface true_surface(const phantom::DrawnTruth::Frame& frame, Structure structure,
                                       double spacing_mm, const Grid& seen);

/// Of the vertices that the truth tells a distance of, in their order; see DrawnErrors.
[[nodiscard]] std::vector<VertexError> vertex_errors(const atlas::SurfacePayload& surface,
                                                     const Affine& workspace_from_lps, int p,
                                                     const TrueSurface& truth);

/// One phase: vertices of the surface to the truth, each with a third of its triangles, and points
/// of the truth to the triangles, with the sign of the nearest triangle's side.
/// @param vertices see vertex_errors  @param true_ml of the whole structure
[[nodiscard]] DrawnErrors drawn_errors(const atlas::SurfacePayload& surface,
                                       const Affine& workspace_from_lps, int p,
                                       const TrueSurface& truth,
                                       const std::vector<VertexError>& vertices, double true_ml);

}  // namespace beatlas::assess
