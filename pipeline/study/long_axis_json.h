#pragma once
/// The LV's long axis as JSON, see schemas/long_axis.schema.json.

#include <nlohmann/json.hpp>

#include "pipeline/core/long_axis.h"

namespace beatlas::study {

[[nodiscard]] nlohmann::json long_axis_to_json(const LongAxis& axis);

/// Strict. A direction that is not quite of length 1 is made so.
/// @throws Error{InvalidInput} with the JSON path; also for another version, a base that does not
/// lie beyond the apex, or an RV's plane in some phases only.
[[nodiscard]] LongAxis long_axis_from_json(const nlohmann::json& json);

}  // namespace beatlas::study
