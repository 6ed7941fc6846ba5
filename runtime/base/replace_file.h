#pragma once
/// Writing files so that nobody ever finds half of one: the one way in which this tree replaces a
/// file.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string_view>

namespace beatlas {

/// Makes a new, empty, hidden file beside `file` (never one that was there, or one that a link
/// leads to), whose name ends like that of `file`, and calls write(temporary), which fills it. Then
/// has it reach the disk and renames it over `file`: at any moment, also if the power fails, the
/// name stands for the old content or the whole new one. If anything fails, the temporary is
/// removed and `file` is untouched.
/// @throws what `write` throws, with an Error{Machine} put into words about `file`; Error{Machine}
/// naming `file` and the reason if anything else fails
void replace_file(const std::filesystem::path& file,
                  const std::function<void(const std::filesystem::path& temporary)>& write);

/// The same with these bytes.
/// @param look called with the whole temporary before it takes the name, which it does not if that
/// throws; may be empty
void replace_file(const std::filesystem::path& file, std::span<const std::byte> bytes,
                  const std::function<void(const std::filesystem::path& temporary)>& look = {});
void replace_file(const std::filesystem::path& file, std::string_view text);

/// Refuses what was named in an output's place by mistake: a file that is there, holds something
/// and does not begin as `text` does, with the same first line or, of a page or picture of text,
/// the same tag. Of a JSON object it must be one, too, with every key that `text` has.
/// @param text all of what is to be written; of a table its first line may do
/// @throws Error{Usage}
void refuse_other_kind(const std::filesystem::path& file, std::string_view text);

/// Whether `file` has the name of such a temporary: left behind by a program that was killed.
[[nodiscard]] bool is_partial(const std::filesystem::path& file);

/// Tries now whether replace_file(file) could make its temporary.
[[nodiscard]] bool can_replace(const std::filesystem::path& file);

}  // namespace beatlas
