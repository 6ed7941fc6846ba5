#include "pipeline/formats/obj.h"

#include <array>
#include <cstdio>

namespace beatlas::formats {

std::string obj_text(const atlas::SurfacePayload& surface, std::size_t phase) {
  std::string text = "# " + std::string(structure_name(surface.structure)) + ", workspace [mm]\n";
  std::array<char, 96> line{};
  for (const Vec3f& vertex : surface.positions[phase]) {
    std::snprintf(line.data(), line.size(), "v %.9g %.9g %.9g\n", static_cast<double>(vertex[0]),
                  static_cast<double>(vertex[1]), static_cast<double>(vertex[2]));
    text += line.data();
  }
  for (const auto& [a, b, c] : surface.triangles) {
    text += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " +
            std::to_string(c + 1) + "\n";
  }
  return text;
}

}  // namespace beatlas::formats
