#pragma once

namespace beatlas::cli {

/// Of the program, as in the root CMakeLists.txt.
inline constexpr const char* kVersion = BEATLAS_VERSION;

}  // namespace beatlas::cli
