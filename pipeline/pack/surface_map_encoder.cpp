#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/surface_map_payload.h"
#include "runtime/base/error.h"

namespace beatlas::pack {
namespace {

using Counts = std::vector<std::uint16_t>;

std::uint16_t counted(double parts) { return static_cast<std::uint16_t>(std::lround(parts)); }

/// Thin as it may be, a wall is one.
std::uint16_t counted_wall(float thickness_mm) {
  return thickness_mm > 0
             ? std::max(std::uint16_t{1},
                        counted(static_cast<double>(thickness_mm) / atlas::kThicknessStepMm))
             : std::uint16_t{0};
}

/// Appends the two planes of bytes.
void put_differences(atlas::ByteWriter& writer, const Counts& differences) {
  std::vector<std::uint8_t> low;
  std::vector<std::uint8_t> high;
  for (const std::uint16_t difference : differences) {
    const unsigned sign = difference >> 15U;
    const unsigned code = (unsigned{difference} << 1U ^ (0U - sign)) & 0xFFFFU;
    low.push_back(static_cast<std::uint8_t>(code & 0xFFU));
    high.push_back(static_cast<std::uint8_t>(code >> 8U));
  }
  writer.put_many(low.data(), low.size());
  writer.put_many(high.data(), high.size());
}

Counts differences_of(const Counts& counts, int modulus) {
  Counts out;
  int before = 0;
  for (const std::uint16_t count : counts) {
    int difference = count - before;
    if (modulus > 0) {  // the shorter way around
      difference = ((difference + modulus / 2) % modulus + modulus) % modulus - modulus / 2;
    }
    out.push_back(static_cast<std::uint16_t>(difference));
    before = count;
  }
  return out;
}

Counts thickness_differences(const std::vector<Counts>& phases) {
  Counts out;
  for (std::size_t p = 0; p < phases.size(); ++p) {
    for (std::size_t v = 0; v < phases[p].size(); ++v) {
      const auto at = [&](bool now, bool own) -> std::uint16_t {
        if ((!now && p == 0) || (!own && v == 0)) return 0;
        return phases[now ? p : p - 1][own ? v : v - 1];
      };
      out.push_back(static_cast<std::uint16_t>(
          phases[p][v] -
          atlas::foretold_thickness(at(true, false), at(false, true), at(false, false))));
    }
  }
  return out;
}

}  // namespace

atlas::Bytes pack_surface_map(const atlas::SurfaceMapPayload& map,
                              const std::vector<std::uint32_t>& given) {
  atlas::check_surface_map(map);
  if (given.size() != map.segment.size()) {
    throw_invalid("a surface map of " + std::string(structure_name(map.structure)) +
                  " has another number of vertices than the surface; give those of one mesh");
  }
  std::vector<std::uint8_t> segments;
  Counts places;
  Counts angles;
  for (const std::uint32_t v : given) {
    segments.push_back(map.segment[v]);
    places.push_back(counted(static_cast<double>(map.long_axis[v]) * atlas::kMapParts));
    angles.push_back(
        counted(static_cast<double>(map.angle_rad[v]) / (2 * std::numbers::pi) * atlas::kMapParts) %
        atlas::kMapParts);
  }
  std::vector<Counts> thickness(map.thickness_mm.size());
  for (std::size_t p = 0; p < thickness.size(); ++p) {
    for (const std::uint32_t v : given) {
      thickness[p].push_back(counted_wall(map.thickness_mm[p][v]));
    }
  }
  atlas::ByteWriter writer;
  writer.put_text(atlas::kMapMagic);
  writer.put(atlas::kMapVersion);
  writer.put(static_cast<std::uint32_t>(given.size()));
  writer.put(static_cast<std::uint32_t>(thickness.size()));
  writer.put(atlas::kThicknessStepMm);
  writer.put_many(segments.data(), segments.size());
  put_differences(writer, differences_of(places, 0));
  put_differences(writer, differences_of(angles, atlas::kMapParts));
  put_differences(writer, thickness_differences(thickness));
  atlas::Bytes entry = zstd_pack(writer.take());
  (void)atlas::decode_surface_map(entry, map.structure);
  return entry;
}

}  // namespace beatlas::pack
