#pragma once
#include <memory>
#include <vector>

#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::cli {

/// Labels on an image grid from the signs of distance fields, one image a phase (phase p at
/// p / phases of the R-R interval): lv_blood, rv_blood or lv_myocardium where the voxel's centre is
/// inside it, the deepest where neighbours overlap by a fraction of a voxel; the rest of the heart
/// where it is inside the heart alone.
/// @param lps_grid patient LPS
/// @throws Error{InvalidInput} if fields differ in their number of phases or there is none.
[[nodiscard]] LabelCycle labels_from_fields(
    const std::vector<std::shared_ptr<const atlas::FieldPayload>>& fields, const Grid& lps_grid,
    const Affine& workspace_from_lps, double rr_interval_s, StageContext& context);

}  // namespace beatlas::cli
