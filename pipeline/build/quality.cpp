#include "pipeline/build/quality.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "pipeline/assess/surface_checks.h"
#include "runtime/base/error.h"

namespace beatlas::build {
namespace {

const report::VolumeCurve& curve_of(const std::vector<report::VolumeCurve>& curves,
                                    Structure structure) {
  for (const report::VolumeCurve& curve : curves) {
    if (curve.structure == structure) return curve;
  }
  throw_invalid("there is a field of " + std::string(structure_name(structure)) +
                ", but the segmentation lacks that structure; run the stages again from segment");
}

/// Of the largest difference, with its sign.
double excess_percent(const std::vector<double>& segmented, const std::vector<double>& made,
                      Structure structure) {
  if (segmented.size() != made.size() || made.empty()) {
    throw_invalid("the segmentation of " + std::string(structure_name(structure)) +
                  " has other phases than the field or surface made from it; run the stages again");
  }
  double gap = 0;
  double largest = 0;
  for (std::size_t p = 0; p < made.size(); ++p) {
    const double here = made[p] - segmented[p];
    if (std::abs(here) > std::abs(gap)) gap = here;
    largest = std::max(largest, segmented[p]);
  }
  return largest > 0 ? 100 * gap / largest : 100;
}

}  // namespace

std::vector<StructureQuality> measure_quality(const std::vector<report::VolumeCurve>& segmented,
                                              const std::vector<FieldCycle>& fields,
                                              const std::vector<SurfaceCycle>& surfaces) {
  std::vector<StructureQuality> out;
  for (const FieldCycle& field : fields) {
    StructureQuality quality;
    quality.structure = field.structure;
    const std::vector<double>& volume_ml = curve_of(segmented, field.structure).volume_ml;
    quality.field_volume_excess_percent =
        excess_percent(volume_ml, field.volume_ml, field.structure);
    for (const SurfaceCycle& surface : surfaces) {
      if (surface.structure != field.structure) continue;
      std::vector<double> enclosed;
      for (const std::vector<Vec3f>& phase : surface.positions) {
        enclosed.push_back(assess::enclosed_volume_ml(surface.triangles, phase));
      }
      quality.has_surface = true;
      quality.surface_volume_excess_percent =
          excess_percent(volume_ml, enclosed, surface.structure);
    }
    out.push_back(quality);
  }
  return out;
}

void demand_quality(const std::vector<StructureQuality>& quality, const QualityOptions& options) {
  for (const StructureQuality& entry : quality) {
    const double field = entry.field_volume_excess_percent;
    const double surface = entry.surface_volume_excess_percent;
    const double worst = std::abs(surface) > std::abs(field) ? surface : field;
    if (std::abs(worst) <= options.max_volume_gap_percent) continue;
    char text[256];
    std::snprintf(
        text, sizeof text,
        "%s would have up to %.1f %% of volume too %s beside its segmentation, the recipe "
        "allows %g %% (/quality/max_volume_gap_percent); no package was written",
        structure_name(entry.structure).data(), std::abs(worst), worst > 0 ? "much" : "little",
        options.max_volume_gap_percent);
    throw Error(ErrorCode::Quality, text);
  }
}

nlohmann::json quality_to_json(const std::vector<StructureQuality>& quality) {
  nlohmann::json out = nlohmann::json::array();
  for (const StructureQuality& entry : quality) {
    nlohmann::json figures{
        {"name", structure_name(entry.structure)},
        {"field_volume_gap_percent", std::abs(entry.field_volume_excess_percent)},
        {"field_volume_excess_percent", entry.field_volume_excess_percent}};
    if (entry.has_surface) {
      figures["surface_volume_gap_percent"] = std::abs(entry.surface_volume_excess_percent);
      figures["surface_volume_excess_percent"] = entry.surface_volume_excess_percent;
    }
    out.push_back(std::move(figures));
  }
  return out;
}

}  // namespace beatlas::build
