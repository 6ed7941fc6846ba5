#pragma once
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/atlas/structures.h"

namespace beatlas::study {

/// Names of structures, see structure_name.
[[nodiscard]] nlohmann::json structures_to_json(const std::vector<Structure>& structures);
/// @throws Error{InvalidInput} naming `path` if it is no list of names, or one stands twice.
[[nodiscard]] std::vector<Structure> structures_from_json(const nlohmann::json& json,
                                                          const std::string& path);

}  // namespace beatlas::study
