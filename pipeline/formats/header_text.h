#pragma once
/// Words and numbers of text headers (NRRD, MetaImage), read strictly. Messages never repeat the
/// text: a header may hold a name.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/formats/voxel_data.h"

namespace beatlas::formats {

inline constexpr std::int64_t kMostBytes = std::int64_t{1} << 40;  ///< skipped, sizes

[[nodiscard]] std::string_view trimmed(std::string_view text);
[[nodiscard]] std::vector<std::string_view> words(std::string_view text);
/// In double quotes or bare: a "b c" -> a, b c
[[nodiscard]] std::vector<std::string> quoted_words(std::string_view text);
[[nodiscard]] std::string lower(std::string_view text);

/// Numbers; NaN and infinity are numbers here. @throws Error{InvalidInput} naming `field`
[[nodiscard]] double number(std::string_view word, const std::string& field);
[[nodiscard]] std::vector<double> numbers(std::string_view text, const std::string& field);
[[nodiscard]] std::int64_t whole(std::string_view word, const std::string& field,
                                 std::int64_t least, std::int64_t most);

/// Takes the next line off the front, without its end.
[[nodiscard]] std::string_view take_line(std::string_view& rest);

/// The first bytes of a file, at most kHeaderBytes: more is no header.
inline constexpr std::size_t kHeaderBytes = std::size_t{1} << 22;
[[nodiscard]] std::string read_start(const std::filesystem::path& file);

/// Where a header says its voxels are: words of "file", "LIST [dimension]" (names in the lines that
/// follow) or "pattern first last step [dimension]"; names count from `folder`.
/// @throws Error{InvalidInput}; also if one lies neither in `folder` nor below it, for a header may
/// come from anybody and what it names goes into studies and packages
[[nodiscard]] std::vector<std::filesystem::path> data_files(std::string_view value,
                                                            std::string_view lines_after,
                                                            const std::filesystem::path& folder);

/// Offset behind `count` further lines of a file, from `offset`.
[[nodiscard]] std::int64_t after_lines(const std::filesystem::path& file, std::int64_t offset,
                                       std::int64_t count);

}  // namespace beatlas::formats
