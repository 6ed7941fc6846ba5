#pragma once
/// Vectors in strict JSON.

#include <string>

#include <nlohmann/json.hpp>

#include "runtime/base/geometry.h"
#include "runtime/base/json_object.h"

namespace beatlas::phantom {

[[nodiscard]] inline nlohmann::json to_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// Sets `value` from an optional array of three numbers, each within [low, high].
inline void read_vector(JsonObject& object, const std::string& key, Vec3& value, double low,
                        double high) {
  if (!object.has(key)) return;
  const nlohmann::json& array = object.at(key);
  bool good = array.is_array() && array.size() == 3;
  for (std::size_t n = 0; good && n < 3; ++n) {
    good = array[n].is_number() && array[n].get<double>() >= low && array[n].get<double>() <= high;
    if (good) value[static_cast<int>(n)] = array[n].get<double>();
  }
  if (!good) {
    throw_invalid(object.path() + "/" + key + " must be three numbers from " +
                  nlohmann::json(low).dump() + " to " + nlohmann::json(high).dump());
  }
}

}  // namespace beatlas::phantom
