#pragma once
#include <set>
#include <string>
#include <string_view>

namespace beatlas {

/// The name that a mistyped word most likely means: the one of the least edit distance (letters
/// put in, left out, replaced or swapped; upper case, '-' and '_' count for nothing), if that is at
/// most a third of its letters, or else the shortest that the word begins; empty if none is near.
/// Of several as near the first.
[[nodiscard]] std::string nearest_name(std::string_view word, const std::set<std::string>& names);

}  // namespace beatlas
