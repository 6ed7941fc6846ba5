#pragma once
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/build/recipe.h"
#include "pipeline/core/shapes.h"
#include "pipeline/report/curves.h"

namespace beatlas::build {

/// How well one structure of the package keeps the volume of its segmentation.
struct StructureQuality {
  Structure structure{};
  /// V - V_segmentation where it is farthest from 0 of all phases, as a share of the largest
  /// V_segmentation of the beat [%], and the phase
  double field_volume_excess_percent = 0;
  int field_phase = 0;
  double surface_volume_excess_percent = 0;  ///< the same for the surface; 0 without one
  int surface_phase = 0;
  bool has_surface = false;
};

/// One entry a field, in order of the fields. @throws Error{InvalidInput} if phases disagree.
[[nodiscard]] std::vector<StructureQuality> measure_quality(
    const std::vector<report::VolumeCurve>& segmented, const std::vector<FieldCycle>& fields,
    const std::vector<SurfaceCycle>& surfaces);

/// @throws Error{Quality} naming structure, figure and limit.
void demand_quality(const std::vector<StructureQuality>& quality, const QualityOptions& options);

[[nodiscard]] nlohmann::json quality_to_json(const std::vector<StructureQuality>& quality);

}  // namespace beatlas::build
