#include "pipeline/cli/self_test_text.h"

#include <cstdio>

namespace beatlas::cli {
namespace {

std::string table(const std::string& head, const std::vector<assess::HiddenError>& rows) {
  if (rows.empty()) return {};
  std::string text = head + "\nstructure       contours   mean mm   p95 mm   bias mm\n";
  for (const assess::HiddenError& row : rows) {
    char line[120];
    std::snprintf(line, sizeof line, "%-15s %8d %9.2f %8.2f %+9.2f\n",
                  structure_name(row.structure).data(), row.contours, row.mm.mean, row.mm.p95,
                  row.mm.bias);
    text += line;
  }
  return text + "\n";
}

std::string number(const char* format, double value) {
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace

std::string self_test_to_text(const assess::SelfTest& found) {
  const std::string apart = number("%.1f mm", found.slices_apart_mm);
  std::string text = table("Hidden slices, foretold by those beside them, " + apart + " apart",
                           found.between_slices);
  text += table("Hidden slices beside an end", found.at_ends);
  text += table("Hidden phases, foretold by those beside them, " +
                    number("%.0f ms", 1e3 * found.phases_apart_s) + " apart",
                found.between_phases);
  if (!text.empty()) text += "What lies more than 6 mm off counts as 6.\n\n";
  if (!found.worst.empty()) text += "Foretold worst, between two others\n";
  for (const assess::HiddenPlace& place : found.worst) {
    text += std::string(structure_name(place.structure)) + " in slice " +
            std::to_string(place.slice) + ", phase " + std::to_string(place.phase) + ": " +
            number("%.1f mm", place.mm.mean) + " in the mean, " + number("%+.1f", place.mm.bias) +
            " outward\n";
  }
  return text;
}

}  // namespace beatlas::cli
