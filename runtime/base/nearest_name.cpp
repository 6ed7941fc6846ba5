#include "runtime/base/nearest_name.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace beatlas {
namespace {

std::string letters_of(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '-' || c == '_') continue;
    out += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return out;
}

/// Optimal string alignment: Levenshtein's distance with neighbours swapped at the cost of one.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t other = a[i - 1] == b[j - 1] ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + other});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string nearest_name(std::string_view word, const std::set<std::string>& names) {
  constexpr std::size_t kLongest = 64;  // what is longer was not mistyped
  constexpr std::size_t kFewestLetters = 3;
  const std::string meant = letters_of(word);
  if (meant.empty() || meant.size() > kLongest) return {};
  std::string nearest;
  std::size_t least = kLongest;
  std::string begun;
  for (const std::string& name : names) {
    const std::string letters = letters_of(name);
    const std::size_t distance = edit_distance(meant, letters);
    if (distance < least && 3 * distance <= letters.size()) {
      least = distance;
      nearest = name;
    }
    const bool begins = meant.size() >= kFewestLetters && letters.starts_with(meant);
    if (begins && (begun.empty() || name.size() < begun.size())) begun = name;
  }
  return nearest.empty() ? begun : nearest;
}

}  // namespace beatlas
