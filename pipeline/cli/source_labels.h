#pragma once
#include <memory>
#include <vector>

#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::cli {

/// What tells where structures are: distances, or of those that have none a surface.
struct Shapes {
  std::vector<std::shared_ptr<const atlas::FieldPayload>> fields;
  std::vector<std::shared_ptr<const atlas::SurfacePayload>> surfaces;
};

/// Labels on an image grid, one image a phase (phase p at p / phases of the R-R interval): a
/// structure's own where the voxel's centre is inside it; the rest of the heart where it is inside
/// the heart alone. Where neighbours overlap by a fraction of a voxel, the one that has distances
/// and is deepest there, else the surface that comes first.
/// @param lps_grid patient LPS
/// @throws Error{InvalidInput} if shapes differ in their number of phases or there is none.
[[nodiscard]] LabelCycle labels_from_shapes(const Shapes& shapes, const Grid& lps_grid,
                                            const Affine& workspace_from_lps, double rr_interval_s,
                                            StageContext& context);

}  // namespace beatlas::cli
