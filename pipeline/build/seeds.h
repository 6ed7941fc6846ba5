#pragma once
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/segment/options.h"

namespace beatlas::build {

inline constexpr double kFarthestMm = 5000;  ///< a place beyond it is in no scanner's bore

/// See schemas/seeds.schema.json. @throws Error{InvalidInput} naming the JSON path.
[[nodiscard]] std::vector<segment::Seed> seeds_from_json(const nlohmann::json& json);
[[nodiscard]] nlohmann::json seeds_to_json(const std::vector<segment::Seed>& seeds);

}  // namespace beatlas::build
