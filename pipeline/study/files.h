#pragma once
/// Writing files so that a reader never sees half of one.

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/base/error.h"
#include "runtime/base/replace_file.h"

namespace beatlas::study {

/// replace_file with these bytes. @throws Error{Machine}
void write_bytes(const std::filesystem::path& file, std::span<const std::byte> bytes);
void write_text(const std::filesystem::path& file, std::string_view text);
/// Indented, keys sorted, with a final newline.
void write_json(const std::filesystem::path& file, const nlohmann::json& json);

/// @throws Error{InvalidInput} if it is missing or unreadable.
[[nodiscard]] std::vector<std::byte> read_bytes(const std::filesystem::path& file);
/// @throws Error{InvalidInput} naming the file and where in it the JSON breaks off; a key that
/// stands twice in one object is refused too.
[[nodiscard]] nlohmann::json read_json(const std::filesystem::path& file);
/// `error` of reading the files that `index` lists, with the index named unless the message begins
/// with a file beside it.
[[nodiscard]] Error said_of(const std::filesystem::path& index, const Error& error);
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& file);

/// Whether the file is there with this content.
[[nodiscard]] bool holds(const std::filesystem::path& file, const std::string& sha256);

/// Makes the folder and those above it. @throws Error{Machine}
void make_folder(const std::filesystem::path& folder);

/// Tries now whether replace_file(file) could work, before long work is done for it.
/// @throws Error{Machine} if `file` is a folder, its folder is missing or cannot be written.
void check_writable(const std::filesystem::path& file);

}  // namespace beatlas::study
