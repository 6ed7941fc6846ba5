#pragma once
/// The mark by which images made from a phantom name it, so that a package made from them finds the
/// truth it may be compared with. Import keeps a text of a file only if it is a mark to the letter:
/// nothing that names a patient can pass for one.

#include <string>
#include <string_view>

namespace beatlas {

/// Whether a text is an identity of a phantom: 64 lower-case hexadecimal digits.
[[nodiscard]] bool is_phantom_identity(std::string_view text) noexcept;

/// "phantom:" and the identity; 72 characters, which fit NIfTI's descrip. "" for "".
[[nodiscard]] std::string phantom_mark(std::string_view identity);

/// The identity if `text` is a mark and nothing else but blanks and nulls at its end; else "".
[[nodiscard]] std::string identity_of_mark(std::string_view text);

}  // namespace beatlas
