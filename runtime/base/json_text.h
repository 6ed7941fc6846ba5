#pragma once
/// JSON from and to text. In one place, because the parser and the writer of nlohmann-json take
/// longer to compile than most files that use them.

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace beatlas {

enum class JsonComments { Refuse, Skip };

/// `is_discarded()` if the text is no JSON.
[[nodiscard]] nlohmann::json parse_json(std::string_view text,
                                        JsonComments comments = JsonComments::Refuse);
/// @param indent spaces a level; -1: in one line
/// @throws nlohmann::json::type_error if a string is no UTF-8
[[nodiscard]] std::string json_text(const nlohmann::json& json, int indent = -1);

}  // namespace beatlas
