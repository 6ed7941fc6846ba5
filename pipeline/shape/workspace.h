#pragma once
/// Patient -> workspace: where the heart lies in paper A's absolute workspace, and its shape there
/// on an isotropic lattice. Rigid: sizes are never changed.

#include <optional>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::shape {

struct RegisterOptions {
  /// [mm] 0.3..3: edge of the isotropic lattice of the shapes; none: see lattice_edge_mm.
  std::optional<double> shape_mm = {};
  double margin_mm = 12.0;  ///< [mm] 4..40: room around each structure
};

/// [mm] Edge of the lattice of shapes: that of the options or, where they name none, a sixth of the
/// distance between slices, from 1 to 1.5, and no more than 2/9 of the LV's wall, which is then
/// three samples of a field thick, to the next 0.05. Fields and surfaces follow it
/// (field::voxel_edge_mm, mesh::triangle_edge_mm). Between slices a surface is known to a fifth of
/// their distance, and finer lattices tell nothing more of it: see README.md.
/// @param wall_mm see wall_thickness.h
[[nodiscard]] double lattice_edge_mm(double slice_distance_mm, std::optional<double> wall_mm,
                                     const RegisterOptions& options);

/// Axes along row, column and row x column of the source. A source of exactly paper A's matrix
/// and spacing maps voxel to voxel; any other has the time-mean centroid of the heart at the
/// workspace's centre.
/// @throws Error{InvalidInput} if the centroid is asked for and there is no heart.
[[nodiscard]] Affine workspace_from_lps(const Grid& source, const CoverageCycle& coverage);

/// [mm] Levels of shapes are kept this far from the surface and clamped there: files stay small.
inline constexpr float kLevelReachMm = 6;

/// One shape per structure of the coverage; no place lies in two of them, and the heart holds all
/// (see shared_places.h).
/// @param segmentation let go of as its shapes are made: whoever hands it over needs that much less
///        memory
/// @throws Error{InvalidInput} if a structure covers no voxel in any phase.
[[nodiscard]] std::vector<ShapeCycle> shapes_in_workspace(Segmentation segmentation,
                                                          const Affine& workspace_from_lps,
                                                          const RegisterOptions& options,
                                                          StageContext& context);

/// The cine (linear) and labels (from the shapes' signs) on the 256 x 256 x 64 grid; grid frame:
/// workspace.
/// @param cine let go of phase by phase
[[nodiscard]] ImageCycle<float> cine_in_workspace(Cine cine, const Affine& workspace_from_lps);
[[nodiscard]] LabelCycle labels_in_workspace(const std::vector<ShapeCycle>& shapes);

}  // namespace beatlas::shape
