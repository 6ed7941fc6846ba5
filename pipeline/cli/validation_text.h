#pragma once
#include <string>

#include "pipeline/assess/validate.h"

namespace beatlas::cli {

/// Tables of at most 100 columns: shapes, motion and wall, force; then what failed.
[[nodiscard]] std::string validation_to_text(const assess::ValidationReport& report);

}  // namespace beatlas::cli
