#include "runtime/device/json_scan.h"

#include <charconv>
#include <cmath>

namespace beatlas::device {
namespace {
constexpr int kDeepest = 32;
}

void JsonScan::white() noexcept {
  const std::size_t next = text_.find_first_not_of(" \t\r\n");
  text_.remove_prefix(next == std::string_view::npos ? text_.size() : next);
}

bool JsonScan::take(char wanted) noexcept {
  white();
  if (text_.empty() || text_.front() != wanted) return false;
  text_.remove_prefix(1);
  return true;
}

bool JsonScan::word(std::string_view wanted) noexcept {
  if (!text_.starts_with(wanted)) return false;
  text_.remove_prefix(wanted.size());
  return true;
}

bool JsonScan::at_end() noexcept {
  white();
  return text_.empty();
}

bool JsonScan::string(std::string_view& out) noexcept {
  if (!take('"')) return false;
  for (std::size_t n = 0; n < text_.size(); ++n) {
    if (text_[n] == '\\') {
      ++n;
    } else if (text_[n] == '"') {
      out = text_.substr(0, n);
      text_.remove_prefix(n + 1);
      return true;
    }
  }
  return false;
}

bool JsonScan::number(double& out) noexcept {
  white();
  const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), out);
  if (error != std::errc() || !std::isfinite(out)) return false;
  text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
  return true;
}

bool JsonScan::skip(int depth) noexcept {
  if (depth > kDeepest) return false;
  white();
  if (text_.empty()) return false;
  std::string_view text;
  double value = 0;
  switch (text_.front()) {
    case '{':
      return object([depth](std::string_view, JsonScan& in) { return in.skip(depth + 1); });
    case '[':
      return array([depth](JsonScan& in) { return in.skip(depth + 1); });
    case '"':
      return string(text);
    case 't':
      return word("true");
    case 'f':
      return word("false");
    case 'n':
      return word("null");
    default:
      return number(value);
  }
}

}  // namespace beatlas::device
