#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "runtime/base/geometry.h"

namespace beatlas::formats {

struct SurfaceMesh {
  std::vector<Vec3> points;  ///< [mm], the file's own frame
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Wavefront OBJ (v and f; polygons as fans; all else is passed over) and STL, binary or ASCII,
/// whose corners at one place become one point, in the order of their first mention.
/// @throws Error{InvalidInput} naming the file and what is wrong with it: another format, cut
/// short, no triangle, an index of no point, a coordinate that is no finite number, more than 20
/// million points or triangles.
[[nodiscard]] SurfaceMesh read_obj(const std::filesystem::path& file);
[[nodiscard]] SurfaceMesh read_stl(const std::filesystem::path& file);

}  // namespace beatlas::formats
