#include "pipeline/assess/self_test.h"

namespace beatlas::assess {
namespace {
using nlohmann::json;

json figures(const DistanceStatistics& mm) {
  return {{"mean_mm", mm.mean}, {"p95_mm", mm.p95}, {"bias_mm", mm.bias}};
}

json rows_of(const std::vector<HiddenError>& rows) {
  json out = json::array();
  for (const HiddenError& row : rows) {
    json entry = figures(row.mm);
    entry["structure"] = structure_name(row.structure);
    entry["contours"] = row.contours;
    out.push_back(std::move(entry));
  }
  return out;
}

}  // namespace

json to_json(const SelfTest& found) {
  json worst = json::array();
  for (const HiddenPlace& place : found.worst) {
    json entry = figures(place.mm);
    entry["structure"] = structure_name(place.structure);
    entry["slice"] = place.slice;
    entry["phase"] = place.phase;
    worst.push_back(std::move(entry));
  }
  return {{"slices_apart_mm", found.slices_apart_mm},
          {"slice_phases", found.slice_phases},
          {"between_slices", rows_of(found.between_slices)},
          {"at_ends", rows_of(found.at_ends)},
          {"phases_apart_s", found.phases_apart_s},
          {"between_phases", rows_of(found.between_phases)},
          {"worst", std::move(worst)}};
}

}  // namespace beatlas::assess
