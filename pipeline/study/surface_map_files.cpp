#include <array>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <optional>

#include "pipeline/study/files.h"
#include "pipeline/study/stage_files.h"
#include "runtime/base/error.h"

namespace beatlas::study {
namespace fs = std::filesystem;
namespace {

constexpr double kThickestMm = 100;
constexpr double kSegments = 17;  // AHA 2002

std::string map_name(Structure structure) {
  return "mesh/map_" + std::string(structure_name(structure)) + ".csv";
}

std::string header_of(std::size_t phases) {
  std::string text = "vertex,long_axis,angle_rad,segment";
  for (std::size_t p = 0; p < phases; ++p) {
    std::array<char, 64> cell{};
    std::snprintf(cell.data(), cell.size(), ",thickness_mm_%03zu", p);
    text += cell.data();
  }
  return text;
}

/// The numbers of a line; none if it holds anything else.
std::optional<std::vector<double>> numbers_of(const std::string& line) {
  std::vector<double> out;
  const char* at = line.data();
  const char* const end = at + line.size();
  while (true) {
    double value = 0;
    const auto [rest, failed] = std::from_chars(at, end, value);
    if (failed != std::errc()) return std::nullopt;
    out.push_back(value);
    if (rest == end) return out;
    if (*rest != ',') return std::nullopt;
    at = rest + 1;
  }
}

void read_row(const std::string& line, std::size_t vertex, SurfaceMap& map) {
  const std::optional<std::vector<double>> row = numbers_of(line);
  const std::size_t phases = map.thickness_mm.size();
  if (!row || row->size() != 4 + phases) {
    throw_invalid("must hold " + std::to_string(4 + phases) + " numbers");
  }
  const auto within = [](double value, double most) { return value >= 0 && value <= most; };
  const std::vector<double>& cell = *row;
  if (cell[0] != static_cast<double>(vertex)) {
    throw_invalid("must be of vertex " + std::to_string(vertex));
  }
  if (!within(cell[1], 1)) throw_invalid("must have a long_axis from 0 to 1");
  if (!within(cell[2], 2 * std::numbers::pi))
    throw_invalid("must have an angle_rad from 0 to 2 pi");
  const bool has_segments = map.structure != Structure::RvBlood;
  if (!has_segments && cell[3] != 0) throw_invalid("must have segment 0, for the RV has none");
  if (has_segments && (!within(cell[3] - 1, kSegments - 1) ||
                       cell[3] != static_cast<double>(static_cast<int>(cell[3])))) {
    throw_invalid("must have a segment from 1 to 17");
  }
  map.long_axis.push_back(static_cast<float>(cell[1]));
  map.angle_rad.push_back(static_cast<float>(cell[2]));
  map.segment.push_back(static_cast<std::uint8_t>(cell[3]));
  for (std::size_t p = 0; p < phases; ++p) {
    if (!within(cell[4 + p], kThickestMm)) throw_invalid("must have thicknesses from 0 to 100 mm");
    map.thickness_mm[p].push_back(static_cast<float>(cell[4 + p]));
  }
}

SurfaceMap read_map(const fs::path& file, const SurfaceCycle& surface) {
  SurfaceMap map;
  map.structure = surface.structure;
  map.thickness_mm.resize(surface.positions.size());
  std::size_t number = 0;  // of the line
  try {
    std::ifstream stream(file, std::ios::binary);
    std::string line;
    const auto next = [&] {
      ++number;
      if (!std::getline(stream, line)) return false;
      if (line.ends_with('\r')) line.pop_back();
      return true;
    };
    if (!next() || line != header_of(surface.positions.size())) {
      throw_invalid("must name the columns as they were written");
    }
    for (std::size_t v = 0; v < surface.positions.front().size(); ++v) {
      if (!next()) throw_invalid("is missing: there must be a line a vertex of the surface");
      read_row(line, v, map);
    }
    if (next()) throw_invalid("is one too many: there must be a line a vertex of the surface");
  } catch (const Error& error) {
    throw error.with_context(file.string() + ": line " + std::to_string(number));
  }
  return map;
}

}  // namespace

FileList write_surface_maps(const fs::path& study, const std::vector<SurfaceMap>& maps) {
  FileList files;
  for (const SurfaceMap& map : maps) {
    std::string text = header_of(map.thickness_mm.size());
    std::array<char, 64> cell{};
    const auto add = [&](const char* format, auto value) {
      std::snprintf(cell.data(), cell.size(), format, value);
      text += cell.data();
    };
    text += '\n';
    for (std::size_t v = 0; v < map.segment.size(); ++v) {
      add("%zu", v);
      add(",%.4f", static_cast<double>(map.long_axis[v]));
      add(",%.4f", static_cast<double>(map.angle_rad[v]));
      add(",%d", static_cast<int>(map.segment[v]));
      for (const std::vector<float>& phase : map.thickness_mm) {
        add(",%.2f", static_cast<double>(phase[v]));
      }
      text += '\n';
    }
    files.push_back(map_name(map.structure));
    write_text(study / files.back(), text);
  }
  return files;
}

std::vector<SurfaceMap> read_surface_maps(const fs::path& study,
                                          const std::vector<SurfaceCycle>& surfaces) {
  std::vector<SurfaceMap> maps;
  for (const SurfaceCycle& surface : surfaces) {
    const fs::path file = study / map_name(surface.structure);
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored)) maps.push_back(read_map(file, surface));
  }
  return maps;
}

}  // namespace beatlas::study
