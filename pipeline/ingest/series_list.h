#pragma once
#include <iterator>
#include <set>
#include <string>

namespace beatlas::ingest {

/// "series 1-5, 11"
[[nodiscard]] inline std::string series_list(const std::set<int>& numbers) {
  std::string out = "series ";
  for (auto it = numbers.begin(); it != numbers.end();) {
    auto last = it;
    auto next = std::next(it);
    while (next != numbers.end() && *next == *last + 1) last = next++;
    if (it != numbers.begin()) out += ", ";
    out += std::to_string(*it);
    if (*last != *it) {
      out += *last == *it + 1 ? ", " : "-";
      out += std::to_string(*last);
    }
    it = next;
  }
  return out;
}

}  // namespace beatlas::ingest
