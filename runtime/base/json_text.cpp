#include "runtime/base/json_text.h"

#include <nlohmann/json.hpp>

namespace beatlas {

nlohmann::json parse_json(std::string_view text, JsonComments comments) {
  return nlohmann::json::parse(text, nullptr, false, comments == JsonComments::Skip);
}

std::string json_text(const nlohmann::json& json, int indent) { return json.dump(indent); }

}  // namespace beatlas
