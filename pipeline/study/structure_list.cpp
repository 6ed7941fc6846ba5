#include "pipeline/study/structure_list.h"

#include <algorithm>

#include "pipeline/study/json_values.h"
#include "runtime/base/error.h"

namespace beatlas::study {

nlohmann::json structures_to_json(const std::vector<Structure>& structures) {
  nlohmann::json out = nlohmann::json::array();
  for (Structure structure : structures) out.push_back(structure_name(structure));
  return out;
}

std::vector<Structure> structures_from_json(const nlohmann::json& list, const std::string& path) {
  std::vector<Structure> out;
  for (const std::string& name : strings_from_json(list, path)) {
    const std::optional<Structure> structure = structure_from_name(name);
    if (!structure) {
      throw_invalid(path + " has '" + name +
                    "', but the structures are heart, lv_blood, rv_blood and lv_myocardium");
    }
    if (std::count(out.begin(), out.end(), *structure) != 0) {
      throw_invalid(path + " has '" + name + "' twice");
    }
    out.push_back(*structure);
  }
  return out;
}

}  // namespace beatlas::study
