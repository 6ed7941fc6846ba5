#pragma once
#include <string>

#include "pipeline/assess/self_test.h"

namespace beatlas::cli {

/// Tables of at most 100 columns: between slices, at the ends, between phases; then the worst
/// places.
[[nodiscard]] std::string self_test_to_text(const assess::SelfTest& found);

}  // namespace beatlas::cli
