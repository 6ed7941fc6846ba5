#include "runtime/app/painted_map.h"

#include <fstream>

#include "runtime/base/error.h"
#include "runtime/base/within.h"
#include "runtime/device/csv_table.h"

namespace beatlas::app {
namespace {

namespace fs = std::filesystem;

std::vector<std::uint8_t> read_labels(const fs::path& file, const palpation::LvWall& wall) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw_invalid(file.string() + " cannot be read; check its name and rights");
  std::string header;
  std::getline(stream, header);
  const bool by_segment = header.find("segment") != std::string::npos;
  stream.clear();
  stream.seekg(0);
  const device::CsvTable table =
      device::read_csv(stream, file.string(), {by_segment ? "segment" : "vertex", "label"});
  const auto whole = [&](std::size_t row, std::size_t column, double least, double most) {
    const double value = table.rows[row][column];
    if (value >= least && value <= most && value == static_cast<double>(static_cast<long>(value))) {
      return static_cast<std::size_t>(value);
    }
    throw_invalid(file.string() + ": '" + table.lines[row] + "' must hold a " +
                  (column == 1  ? "label"
                   : by_segment ? "segment"
                                : "vertex") +
                  " from " + std::to_string(static_cast<long>(least)) + " to " +
                  std::to_string(static_cast<long>(most)));
  };
  std::vector<std::uint8_t> of_segment(palpation::kSegments + 1);
  std::vector<std::uint8_t> labels(wall.vertex_count());
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const auto label = static_cast<std::uint8_t>(whole(row, 1, 0, 255));
    if (by_segment) {
      of_segment[whole(row, 0, 1, palpation::kSegments)] = label;
    } else {
      labels[whole(row, 0, 0, static_cast<double>(labels.size() - 1))] = label;
    }
  }
  if (by_segment) {
    for (std::size_t v = 0; v < labels.size(); ++v) labels[v] = of_segment[wall.map().segment[v]];
  }
  return labels;
}

}  // namespace

palpation::PaintedMaps read_painted_maps(const std::vector<palpation::Region>& regions,
                                         const fs::path& folder, const palpation::LvWall& wall) {
  palpation::PaintedMaps out;
  for (const palpation::Region& region : regions) {
    if (region.painted.empty() || out.contains(region.painted)) continue;
    const fs::path file = folder / region.painted;
    std::error_code ignored;
    if (fs::exists(file, ignored) && !lies_within(file, folder)) {
      throw_invalid("the painted map " + region.painted +
                    " lies outside the folder of the file that names it; put it beside that");
    }
    out[region.painted] = read_labels(file, wall);
  }
  return out;
}

}  // namespace beatlas::app
