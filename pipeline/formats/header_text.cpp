#include "pipeline/formats/header_text.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "pipeline/formats/byte_source.h"
#include "runtime/base/error.h"
#include "runtime/base/within.h"

namespace beatlas::formats {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBlank = " \t\r\n\f\v";
constexpr std::int64_t kMostParts = 10000;

/// A printf pattern with one %d, %i, or either with a width.
struct Pattern {
  std::string before;
  std::string after;
  std::size_t width = 0;
  bool zeros = false;

  [[nodiscard]] std::string name(std::int64_t value) const {
    std::string digits = std::to_string(value);
    if (digits.size() < width) digits.insert(0, width - digits.size(), zeros ? '0' : ' ');
    return before + digits + after;
  }
};

Pattern parse_pattern(std::string_view text) {
  Pattern out;
  const std::size_t at = text.find('%');
  out.before = text.substr(0, at);
  std::size_t next = at + 1;
  if (next < text.size() && text[next] == '0') {
    out.zeros = true;
    ++next;
  }
  while (next < text.size() && text[next] >= '0' && text[next] <= '9' && out.width < 100) {
    out.width = 10 * out.width + static_cast<std::size_t>(text[next++] - '0');
  }
  const bool ends = next < text.size() && (text[next] == 'd' || text[next] == 'i');
  if (!ends || out.width > 20 || text.find('%', next) != std::string_view::npos) {
    throw_invalid("the pattern of its data files cannot be read");
  }
  out.after = text.substr(next + 1);
  return out;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> out;
  for (std::string_view rest = trimmed(text); !rest.empty(); rest = trimmed(rest)) {
    out.push_back(rest.substr(0, rest.find_first_of(kBlank)));
    rest.remove_prefix(out.back().size());
  }
  return out;
}

std::vector<std::string> quoted_words(std::string_view text) {
  std::vector<std::string> out;
  for (std::string_view rest = trimmed(text); !rest.empty(); rest = trimmed(rest)) {
    if (rest.front() != '"') {
      out.emplace_back(rest.substr(0, rest.find_first_of(kBlank)));
      rest.remove_prefix(out.back().size());
      continue;
    }
    const std::size_t end = std::min(rest.find('"', 1), rest.size() - 1);
    out.emplace_back(rest.substr(1, end == 0 ? 0 : end - 1));
    rest.remove_prefix(end + 1);
  }
  return out;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

double number(std::string_view word, const std::string& field) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) {
    throw_invalid("its header field \"" + field + "\" holds no number where one should be");
  }
  return value;
}

std::vector<double> numbers(std::string_view text, const std::string& field) {
  std::vector<double> out;
  for (const std::string_view word : words(text)) out.push_back(number(word, field));
  return out;
}

std::int64_t whole(std::string_view word, const std::string& field, std::int64_t least,
                   std::int64_t most) {
  const std::string_view text = trimmed(word);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < least || value > most) {
    throw_invalid("its header field \"" + field + "\" holds no whole number that can be");
  }
  return value;
}

std::string_view take_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string read_start(const fs::path& file) {
  const auto size = static_cast<std::size_t>(size_of_file(file));
  std::string out(std::min(size, kHeaderBytes), '\0');
  out.resize(open_bytes(file, 0, Packing::Raw)
                 ->read(reinterpret_cast<std::byte*>(out.data()), out.size()));
  return out;
}

std::vector<fs::path> data_files(std::string_view value, std::string_view lines_after,
                                 const fs::path& folder) {
  const auto parts = words(value);
  if (parts.empty()) throw_invalid("its header names no data file");
  std::vector<fs::path> out;
  if (parts[0] == "LIST") {
    while (!lines_after.empty()) {
      const std::string_view name = trimmed(take_line(lines_after));
      if (!name.empty()) out.push_back(folder / name);
      if (std::ssize(out) > kMostParts) throw_invalid("its header names too many data files");
    }
  } else if (parts.size() >= 4 && parts[0].find('%') != std::string_view::npos) {
    constexpr std::int64_t kMost = 1000000000;
    const Pattern pattern = parse_pattern(parts[0]);
    const std::int64_t first = whole(parts[1], "data file", -kMost, kMost);
    const std::int64_t last = whole(parts[2], "data file", -kMost, kMost);
    const std::int64_t step = whole(parts[3], "data file", -kMost, kMost);
    if (step == 0 || (last - first) / step < 0 || (last - first) / step >= kMostParts) {
      throw_invalid("the numbers of its data files cannot be");
    }
    for (std::int64_t n = 0; n <= (last - first) / step; ++n) {
      out.push_back(folder / pattern.name(first + n * step));
    }
  } else {
    out.push_back(folder / trimmed(value));
  }
  std::error_code ignored;
  for (const fs::path& file : out) {
    if (!fs::is_regular_file(file, ignored)) {
      throw_invalid("a data file that its header names is not where it says");
    }
    if (!lies_within(file, folder)) {
      throw_invalid(
          "its header names a data file outside the header's folder; put the data beside it");
    }
  }
  if (out.empty()) throw_invalid("its header names no data file");
  return out;
}

std::int64_t after_lines(const fs::path& file, std::int64_t offset, std::int64_t count) {
  if (count == 0) return offset;
  const auto source = open_bytes(file, offset, Packing::Raw);
  std::array<std::byte, 4096> piece{};
  while (count > 0) {
    const std::size_t got = source->read(piece.data(), piece.size());
    if (got == 0) throw_invalid("it is truncated: lines before its data are missing");
    for (std::size_t i = 0; i < got && count > 0; ++i) {
      ++offset;
      if (piece[i] == std::byte{'\n'}) --count;
    }
  }
  return offset;
}

}  // namespace beatlas::formats
