#include <array>
#include <string>

#include "pipeline/assess/validate.h"

namespace beatlas::assess {
namespace {

template <class Errors, std::size_t N>
nlohmann::json figures_to_json(const std::array<Figure<Errors>, N>& table, const Errors& errors) {
  nlohmann::json out = nlohmann::json::object();
  for (const Figure<Errors>& figure : table) out[figure.name] = errors.*figure.value;
  return out;
}

nlohmann::json structure_to_json(const StructureErrors& structure) {
  nlohmann::json phases = nlohmann::json::array();
  for (std::size_t p = 0; p < structure.phases.size(); ++p) {
    nlohmann::json phase = figures_to_json(kPhaseFigures, structure.phases[p]);
    phase["points"] = structure.phases[p].points;
    if (p < structure.wall_thickness.size()) {
      const ThicknessErrors& wall = structure.wall_thickness[p];
      nlohmann::json& entry = phase["wall_thickness"] = figures_to_json(kThicknessFigures, wall);
      entry["points"] = wall.points;
      entry["missing"] = wall.missing;
    }
    phases.push_back(std::move(phase));
  }
  nlohmann::json out{{"name", std::string(structure_name(structure.structure))},
                     {"phases", phases}};
  if (structure.motion) {
    nlohmann::json& entry = out["motion"] = figures_to_json(kMotionFigures, *structure.motion);
    entry["points"] = structure.motion->points;
  }
  if (structure.map) {
    nlohmann::json& entry = out["map"] = figures_to_json(kMapFigures, *structure.map);
    if (structure.map->named > 0) entry.update(figures_to_json(kSegmentFigures, *structure.map));
    entry["points"] = structure.map->points;
    entry["missing"] = structure.map->missing;
    entry["named"] = structure.map->named;
  }
  if (structure.ejection_fraction_error) {
    out["ejection_fraction_error"] = *structure.ejection_fraction_error;
  }
  return out;
}

nlohmann::json drawn_to_json(const DrawnStructure& drawn) {
  nlohmann::json phases = nlohmann::json::array();
  for (const DrawnErrors& errors : drawn.phases) {
    phases.push_back(figures_to_json(kDrawnFigures, errors));
    phases.back()["points"] = errors.points;
  }
  nlohmann::json out{{"name", std::string(structure_name(drawn.structure))}, {"phases", phases}};
  if (drawn.band_percent) out["band_percent"] = *drawn.band_percent;
  return out;
}

nlohmann::json force_to_json(const FeltErrors& force) {
  nlohmann::json out = figures_to_json(kForceFigures, force.errors);
  out["structure"] = std::string(structure_name(force.structure));
  out["stiffness_n_per_m"] = force.stiffness_n_per_m;
  out["trajectories"] = force.errors.trajectories;
  out["ticks"] = force.errors.ticks;
  out["contact_ticks"] = force.errors.contact_ticks;
  out["contact_differs_ticks"] = force.errors.contact_differs_ticks;
  return out;
}

}  // namespace

nlohmann::json report_to_json(const ValidationReport& report) {
  nlohmann::json structures = nlohmann::json::array();
  for (const StructureErrors& structure : report.structures) {
    structures.push_back(structure_to_json(structure));
  }
  nlohmann::json drawn = nlohmann::json::array();
  for (const DrawnStructure& each : report.drawn) drawn.push_back(drawn_to_json(each));
  nlohmann::json out{{"structures", structures},
                     {"drawn", drawn},
                     {"held_to", std::string(report.held_to)},
                     {"passed", report.passed},
                     {"failures", report.failures}};
  if (report.force) out["force"] = force_to_json(*report.force);
  return out;
}

}  // namespace beatlas::assess
