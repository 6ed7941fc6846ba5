#pragma once
/// Files as a user would write them without a package: bytes, and bytes packed by zstd.

#include <filesystem>
#include <string>

namespace beatlas::bench {

/// @throws Error{Machine} if it cannot be written or read.
void write_file(const std::filesystem::path& file, const std::string& bytes);
[[nodiscard]] std::string read_file(const std::filesystem::path& file);

/// One frame of level 3, and what it held. @throws Error{Machine} if zstd fails.
[[nodiscard]] std::string zstd_packed(const std::string& bytes);
[[nodiscard]] std::string zstd_unpacked(const std::string& frame);

}  // namespace beatlas::bench
