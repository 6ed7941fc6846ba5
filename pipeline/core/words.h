#pragma once
/// Words that messages share.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/atlas/structures.h"

namespace beatlas {

/// Of labels, see runtime/atlas/structures.h; commands take them, too.
inline constexpr std::array<std::string_view, kLastLabel + 1> kLabelWords{
    "background",    "rv_blood", "lv_myocardium", "lv_blood",
    "rest_of_heart", "la_blood", "ra_blood",      "aorta"};

/// "1 phase", "2 phases".
template <class Count>
[[nodiscard]] std::string counted(Count count, std::string_view thing) {
  return std::to_string(count) + " " + std::string(thing) + (count == 1 ? "" : "s");
}

/// "a", "a and b", "a, b and c".
[[nodiscard]] inline std::string listed(const std::vector<std::string>& things) {
  std::string out;
  for (std::size_t n = 0; n < things.size(); ++n) {
    if (n > 0) out += n + 1 == things.size() ? " and " : ", ";
    out += things[n];
  }
  return out;
}

/// A word of a command that is shown to be typed, such as a path with spaces: in double quotes
/// where a shell would take it apart.
[[nodiscard]] inline std::string shell_word(const std::string& word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./+:@%,=";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string out = "\"";
  for (const char c : word) {
    if (c == '"' || c == '\\' || c == '$' || c == '`') out += '\\';
    out += c;
  }
  return out + '"';
}

}  // namespace beatlas
