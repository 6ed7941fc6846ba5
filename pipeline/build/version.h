#pragma once

namespace beatlas::build {

/// Of the program, as in the root CMakeLists.txt.
inline constexpr const char* kVersion = BEATLAS_VERSION;

}  // namespace beatlas::build
