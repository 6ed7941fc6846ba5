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

struct Excess {
  double percent = 0;
  int phase = 0;
};

/// The largest difference, with its sign.
Excess largest_excess(const std::vector<double>& segmented, const std::vector<double>& made,
                      Structure structure) {
  if (segmented.size() != made.size() || made.empty()) {
    throw_invalid("the segmentation of " + std::string(structure_name(structure)) +
                  " has other phases than the field or surface made from it; run the stages again");
  }
  double gap = 0;
  double largest = 0;
  Excess out;
  for (std::size_t p = 0; p < made.size(); ++p) {
    const double here = made[p] - segmented[p];
    if (std::abs(here) > std::abs(gap)) {
      gap = here;
      out.phase = static_cast<int>(p);
    }
    largest = std::max(largest, segmented[p]);
  }
  out.percent = largest > 0 ? 100 * gap / largest : 100;
  return out;
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
    const Excess of_field = largest_excess(volume_ml, field.volume_ml, field.structure);
    quality.field_volume_excess_percent = of_field.percent;
    quality.field_phase = of_field.phase;
    for (const SurfaceCycle& surface : surfaces) {
      if (surface.structure != field.structure) continue;
      std::vector<double> enclosed;
      for (const std::vector<Vec3f>& phase : surface.positions) {
        enclosed.push_back(assess::enclosed_volume_ml(surface.triangles, phase));
      }
      quality.has_surface = true;
      const Excess of_surface = largest_excess(volume_ml, enclosed, surface.structure);
      quality.surface_volume_excess_percent = of_surface.percent;
      quality.surface_phase = of_surface.phase;
    }
    out.push_back(quality);
  }
  return out;
}

void demand_quality(const std::vector<StructureQuality>& quality, const QualityOptions& options) {
  for (const StructureQuality& entry : quality) {
    const double field = entry.field_volume_excess_percent;
    const double surface = entry.surface_volume_excess_percent;
    const bool of_surface = std::abs(surface) > std::abs(field);
    const double worst = of_surface ? surface : field;
    if (std::abs(worst) <= options.max_volume_gap_percent) continue;
    char text[256];
    std::snprintf(
        text, sizeof text,
        "%s would have %.1f %% of its largest volume in the beat too %s in phase %d beside its "
        "segmentation, the recipe allows %g %% (/quality/max_volume_gap_percent); no package was "
        "written",
        structure_name(entry.structure).data(), std::abs(worst), worst > 0 ? "much" : "little",
        of_surface ? entry.surface_phase : entry.field_phase, options.max_volume_gap_percent);
    throw Error(ErrorCode::Quality, text);
  }
}

nlohmann::json quality_to_json(const std::vector<StructureQuality>& quality) {
  nlohmann::json out = nlohmann::json::array();
  for (const StructureQuality& entry : quality) {
    nlohmann::json figures{
        {"name", structure_name(entry.structure)},
        {"field_volume_gap_percent", std::abs(entry.field_volume_excess_percent)},
        {"field_volume_excess_percent", entry.field_volume_excess_percent},
        {"field_volume_gap_phase", entry.field_phase}};
    if (entry.has_surface) {
      figures["surface_volume_gap_percent"] = std::abs(entry.surface_volume_excess_percent);
      figures["surface_volume_excess_percent"] = entry.surface_volume_excess_percent;
      figures["surface_volume_gap_phase"] = entry.surface_phase;
    }
    out.push_back(std::move(figures));
  }
  return out;
}

}  // namespace beatlas::build
