#include "runtime/atlas/surface_map_payload.h"

#include <algorithm>
#include <numbers>

#include "runtime/atlas/manifest.h"
#include "runtime/atlas/payload_check.h"
#include "runtime/atlas/zstd_frame.h"

namespace beatlas::atlas {
namespace {

/// Differences of `count` counts, from their two planes of bytes.
std::vector<std::uint16_t> read_differences(ByteReader& reader, std::size_t count) {
  const ByteView low = reader.take(count);
  const ByteView high = reader.take(count);
  std::vector<std::uint16_t> out(count);
  for (std::size_t n = 0; n < count; ++n) {
    const unsigned code = std::to_integer<unsigned>(low[n]) | std::to_integer<unsigned>(high[n])
                                                                  << 8U;
    out[n] = static_cast<std::uint16_t>((code >> 1U) ^ (0U - (code & 1U)));
  }
  return out;
}

std::vector<float> read_places(ByteReader& reader, std::size_t vertices) {
  std::vector<float> out;
  out.reserve(vertices);
  std::uint16_t before = 0;
  for (const std::uint16_t difference : read_differences(reader, vertices)) {
    before = static_cast<std::uint16_t>(before + difference);
    require(before <= kMapParts, "surface map has a place beyond the long axis");
    out.push_back(static_cast<float>(before) / kMapParts);
  }
  return out;
}

std::vector<float> read_angles(ByteReader& reader, std::size_t vertices) {
  std::vector<float> out;
  out.reserve(vertices);
  unsigned before = 0;
  for (const std::uint16_t difference : read_differences(reader, vertices)) {
    before = (before + difference) % kMapParts;
    out.push_back(static_cast<float>(2 * std::numbers::pi / kMapParts * before));
  }
  return out;
}

std::vector<std::vector<float>> read_thickness(ByteReader& reader, std::size_t vertices,
                                               std::size_t phases, double step_mm) {
  std::vector<std::uint16_t> counts = read_differences(reader, vertices * phases);
  std::vector<std::vector<float>> out(phases);
  for (std::size_t p = 0; p < phases; ++p) {
    std::uint16_t* now = counts.data() + p * vertices;
    const std::uint16_t* last = p == 0 ? nullptr : now - vertices;
    out[p].reserve(vertices);
    for (std::size_t v = 0; v < vertices; ++v) {
      const std::uint16_t before = v == 0 ? std::uint16_t{0} : now[v - 1];
      const std::uint16_t last_before = last == nullptr || v == 0 ? std::uint16_t{0} : last[v - 1];
      const std::uint16_t own = last == nullptr ? std::uint16_t{0} : last[v];
      now[v] = static_cast<std::uint16_t>(now[v] + foretold_thickness(before, own, last_before));
      out[p].push_back(static_cast<float>(step_mm * now[v]));
    }
  }
  return out;
}

}  // namespace

void check_surface_map(const SurfaceMapPayload& map) {
  const std::size_t vertices = map.segment.size();
  const auto within = [](const std::vector<float>& values, double most) {
    return std::all_of(values.begin(), values.end(), [most](float value) {
      return value >= 0 && static_cast<double>(value) <= most;
    });
  };
  require(vertices > 0 && !map.thickness_mm.empty(), "surface map is empty");
  require(map.thickness_mm.size() <= static_cast<std::size_t>(kMaxPhases),
          "surface map has too many phases");
  require(map.long_axis.size() == vertices && map.angle_rad.size() == vertices,
          "surface map has lists of different lengths");
  require(within(map.long_axis, 1), "surface map has a place beyond the long axis");
  require(within(map.angle_rad, 2 * std::numbers::pi + 1e-6),
          "surface map has an angle out of range");
  for (const std::uint8_t segment : map.segment) {
    if (map.structure == Structure::RvBlood) {
      require(segment == 0, "surface map of the right ventricle has a segment");
    } else {
      require(segment >= 1 && segment <= kMapSegments,
              "surface map has a segment that is none of 17");
    }
  }
  for (const std::vector<float>& phase : map.thickness_mm) {
    require(phase.size() == vertices, "surface map has phases of different lengths");
    require(within(phase, kThickestMm), "surface map has a thickness out of range");
  }
}

SurfaceMapPayload decode_surface_map(ByteView entry, Structure structure) {
  const Bytes bytes = zstd_unpack(entry);
  ByteReader reader(bytes);
  reader.expect_magic(kMapMagic);
  require(reader.get<std::uint32_t>() == kMapVersion, "surface map is of an unknown version");
  const std::uint64_t vertices = reader.get<std::uint32_t>();
  const std::uint64_t phases = reader.get<std::uint32_t>();
  const auto step_mm = reader.get<double>();
  require(phases >= 1 && phases <= static_cast<std::uint64_t>(kMaxPhases),
          "surface map has a phase count out of range");
  require(step_mm >= 1e-4 && step_mm <= 1, "surface map has a step out of range");
  // < 2^32 * 2^12: what follows is there, so nothing larger than the entry is allocated for.
  require(reader.remaining() == vertices * (5 + 2 * phases),
          "surface map has counts that its size contradicts");
  SurfaceMapPayload map;
  map.structure = structure;
  map.segment.resize(vertices);
  reader.get_many(map.segment.data(), map.segment.size());
  map.long_axis = read_places(reader, vertices);
  map.angle_rad = read_angles(reader, vertices);
  map.thickness_mm = read_thickness(reader, vertices, phases, step_mm);
  check_surface_map(map);
  return map;
}

}  // namespace beatlas::atlas
