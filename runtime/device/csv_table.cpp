#include "runtime/device/csv_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "runtime/base/error.h"

namespace beatlas::device {
namespace {

std::string_view trim(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(trim(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

bool next_line(std::istream& stream, std::string& line) {
  if (!std::getline(stream, line)) return false;
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return true;
}

// Where the header names columns. @throws Error{InvalidInput} unless it names each once.
std::vector<std::size_t> places_in(const std::vector<std::string>& columns,
                                   const std::vector<std::string>& read, const std::string& name) {
  std::vector<std::size_t> places;
  for (const std::string& column : read) {
    const auto found = std::find(columns.begin(), columns.end(), column);
    if (found == columns.end()) {
      throw_invalid(name + ", line 1: column " + column + " is missing; the header must name it");
    }
    if (std::count(columns.begin(), columns.end(), column) > 1) {
      throw_invalid(name + ", line 1: column " + column + " is there twice; keep one");
    }
    places.push_back(static_cast<std::size_t>(found - columns.begin()));
  }
  return places;
}

// False for what is no finite number, or more than one.
bool read_number(std::string_view field, double& value) {
  if (field.starts_with('+')) field.remove_prefix(1);
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end == field.data() + field.size() && std::isfinite(value);
}

}  // namespace

CsvTable read_csv(std::istream& stream, const std::string& name,
                  const std::vector<std::string>& wanted,
                  const std::vector<std::string>& if_there) {
  CsvTable table;
  std::string line;
  if (!next_line(stream, line)) {
    throw_invalid(name + " is empty; its first line must name the columns");
  }
  if (line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
  table.header = line;
  for (std::string_view column : split(table.header)) table.columns.emplace_back(column);
  const std::vector<std::string>& columns = table.columns;
  std::vector<std::string> read = wanted;
  for (const std::string& column : if_there) {
    if (std::find(columns.begin(), columns.end(), column) != columns.end()) read.push_back(column);
  }
  const std::vector<std::size_t> places = places_in(columns, read, name);
  for (int number = 2; next_line(stream, line); ++number) {
    if (trim(line).empty()) continue;
    const std::string where = name + ", line " + std::to_string(number);
    const std::vector<std::string_view> fields = split(line);
    if (fields.size() != columns.size()) {
      const std::size_t column = std::min(fields.size(), columns.size());
      throw_invalid(where + ", column " + std::to_string(column + 1) + ": there are " +
                    std::to_string(fields.size()) + " fields where the header names " +
                    std::to_string(columns.size()));
    }
    std::vector<double>& row = table.rows.emplace_back();
    for (std::size_t c = 0; c < places.size(); ++c) {
      double value = 0;
      if (!read_number(fields[places[c]], value)) {
        throw_invalid(where + ", column " + read[c] + ": must be a finite number");
      }
      row.push_back(value);
    }
    table.lines.push_back(line);
  }
  if (stream.bad()) throw Error(ErrorCode::Machine, name + " cannot be read to its end");
  return table;
}

}  // namespace beatlas::device
