#pragma once
/// Numbers from a CSV file with a header; strict, every error names line and column.

#include <istream>
#include <string>
#include <vector>

namespace beatlas::device {

/// The wanted columns of every row, beside the rows' own text.
struct CsvTable {
  std::string header;                     ///< the first line as it stood
  std::vector<std::string> columns;       ///< names in the header, in its order
  std::vector<std::string> lines;         ///< the other lines that are not empty
  std::vector<std::vector<double>> rows;  ///< [row][wanted column]
};

/// Reads columns `wanted` (by name, in any order; others are passed over). Comma-separated, no
/// quotes; LF or CRLF; a byte order mark, spaces around a field and empty lines are skipped.
/// @param name of the file, for messages  @param if_there columns after the wanted ones that may be
/// missing: rows are so much shorter then
/// @throws Error{InvalidInput} naming line and column of what is missing, twice there, no finite
/// number, or of a line with too few or too many fields.
[[nodiscard]] CsvTable read_csv(std::istream& stream, const std::string& name,
                                const std::vector<std::string>& wanted,
                                const std::vector<std::string>& if_there = {});

}  // namespace beatlas::device
