#include "runtime/app/region_maps.h"

#include <fstream>
#include <map>

#include "runtime/app/text.h"
#include "runtime/base/error.h"
#include "runtime/base/within.h"
#include "runtime/device/csv_table.h"
#include "runtime/palpation/measured.h"

namespace beatlas::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostPoints = 100000;

/// Whether the first line names a column so; the stream stands at its begin again.
bool names_column(std::ifstream& stream, const std::string& name) {
  std::string header;
  std::getline(stream, header);
  stream.clear();
  stream.seekg(0);
  return header.find(name) != std::string::npos;
}

std::size_t whole(const device::CsvTable& table, std::size_t row, std::size_t column,
                  const fs::path& file, const char* what, double most, double least = 0) {
  const double value = table.rows[row][column];
  if (value >= least && value <= most && value == static_cast<double>(static_cast<long>(value))) {
    return static_cast<std::size_t>(value);
  }
  throw_invalid(file.string() + ": '" + table.lines[row] + "' must hold a " + what + " from " +
                std::to_string(static_cast<long>(least)) + " to " +
                std::to_string(static_cast<long>(most)));
}

std::vector<std::uint8_t> read_labels(const fs::path& file, const palpation::LvWall& wall) {
  std::ifstream stream = open_text(file.string());
  const bool by_segment = names_column(stream, "segment");
  const device::CsvTable table =
      device::read_csv(stream, file.string(), {by_segment ? "segment" : "vertex", "label"});
  std::vector<std::uint8_t> of_segment(palpation::kSegments + 1);
  std::vector<std::uint8_t> labels(wall.vertex_count());
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const auto label = static_cast<std::uint8_t>(whole(table, row, 1, file, "label", 255));
    if (by_segment) {
      of_segment[whole(table, row, 0, file, "segment", palpation::kSegments, 1)] = label;
    } else {
      labels[whole(table, row, 0, file, "vertex", static_cast<double>(labels.size() - 1))] = label;
    }
  }
  if (by_segment) {
    for (std::size_t v = 0; v < labels.size(); ++v) labels[v] = of_segment[wall.map().segment[v]];
  }
  return labels;
}

std::vector<float> read_kpa(const fs::path& file, const palpation::LvWall& wall,
                            const Affine& workspace_from_lps, double reach_mm) {
  std::ifstream stream = open_text(file.string());
  const bool by_vertex = names_column(stream, "vertex");
  const device::CsvTable table =
      by_vertex ? device::read_csv(stream, file.string(), {"kpa", "vertex"})
                : device::read_csv(stream, file.string(), {"kpa", "x_mm", "y_mm", "z_mm"});
  if (table.rows.empty() || table.rows.size() > kMostPoints) {
    throw_invalid(file.string() + " must have 1 to " + std::to_string(kMostPoints) + " places");
  }
  std::vector<float> of_vertex(wall.vertex_count());
  std::vector<palpation::MeasuredPoint> points;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const std::vector<double>& values = table.rows[row];
    if (!(values[0] >= palpation::kLeastKpa && values[0] <= palpation::kMostKpa)) {
      throw_invalid(file.string() + ": '" + table.lines[row] +
                    "' must hold a stiffness from 0.05 to 1000 kPa; myocardium has 1 to some 100 "
                    "kPa: is it in Pa or MPa?");
    }
    if (by_vertex) {
      of_vertex[whole(table, row, 1, file, "vertex", static_cast<double>(of_vertex.size() - 1))] =
          static_cast<float>(values[0]);
    } else {
      points.push_back(
          {.mm = workspace_from_lps * Vec3(values[1], values[2], values[3]), .kpa = values[0]});
    }
  }
  if (by_vertex) return of_vertex;
  try {
    return palpation::kpa_of_wall(wall, points, reach_mm);
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

/// Of a map beside the file that names it.
fs::path beside(const std::string& name, const fs::path& folder) {
  const fs::path file = folder / name;
  std::error_code ignored;
  if (fs::exists(file, ignored) && !lies_within(file, folder)) {
    throw_invalid("the map " + name +
                  " lies outside the folder of the file that names it; put it beside that");
  }
  return file;
}

}  // namespace

palpation::RegionMaps read_region_maps(const std::vector<palpation::Region>& regions,
                                       const fs::path& folder, const palpation::LvWall& wall,
                                       const Affine& workspace_from_lps) {
  palpation::RegionMaps out;
  std::map<std::string, double> reach_mm;
  for (const palpation::Region& region : regions) {
    if (!region.painted.empty() && !out.painted.contains(region.painted)) {
      out.painted[region.painted] = read_labels(beside(region.painted, folder), wall);
    }
    if (region.measured.empty()) continue;
    const auto [known, added] = reach_mm.try_emplace(region.measured, region.reach_mm);
    if (known->second != region.reach_mm) {
      throw_invalid("the measured map " + region.measured +
                    " is named twice, with two reach_mm; name it once");
    }
    if (!added) continue;
    out.measured[region.measured] =
        read_kpa(beside(region.measured, folder), wall, workspace_from_lps, region.reach_mm);
  }
  return out;
}

}  // namespace beatlas::app
