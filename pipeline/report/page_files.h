#pragma once
#include <string_view>

namespace beatlas::report {

/// A file of the report's page, put into the program when it was built: those of page/, and
/// three.min.js and OrbitControls.js of three.js. Empty if there is none of that name.
[[nodiscard]] std::string_view page_file(std::string_view name) noexcept;

}  // namespace beatlas::report
