#pragma once

namespace beatlas::build {

/// Of the program, as in the root CMakeLists.txt.
inline constexpr const char* kVersion = BEATLAS_VERSION;

/// SHA-256 of the sources of pipeline and runtime, the player's own left out. It tells two programs
/// of one version apart: what one of them left in a study, the other makes anew.
[[nodiscard]] const char* sources_sha256() noexcept;

}  // namespace beatlas::build
