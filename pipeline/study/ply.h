#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "runtime/base/geometry.h"

namespace beatlas::study {

struct TriangleMesh {
  std::vector<Vec3f> vertices;  ///< [mm]
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Binary little-endian PLY with float x, y, z and vertex_indices; replaces the file whole.
/// @throws Error{Machine}
void write_ply(const std::filesystem::path& file, const TriangleMesh& mesh);

/// Reads ASCII or binary little-endian PLY; further properties and elements, as mesh editors add
/// them, are passed over. @throws Error{InvalidInput} naming the file and what is wrong with it:
/// cut short, no triangles, an index beyond the vertices, a coordinate that is no finite number.
[[nodiscard]] TriangleMesh read_ply(const std::filesystem::path& file);

}  // namespace beatlas::study
