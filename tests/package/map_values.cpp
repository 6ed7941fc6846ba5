/// map_values PACKAGE STRUCTURE LEVEL: a map as the reader gives it; a line a vertex: long
/// axis, angle, segment, thickness of each phase.

#include <cstdio>
#include <cstdlib>

#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const auto structure = beatlas::structure_from_name(argv[2]);
  const int level = std::atoi(argv[3]);
  if (!structure) return 2;
  try {
    const auto map =
        beatlas::atlas::Atlas::open(
            argv[1], {.fields = {}, .surfaces = {}, .maps = {*structure}, .levels = {level}})
            .surface_map(*structure, level);
    for (std::size_t v = 0; v < map->segment.size(); ++v) {
      std::printf("%.9g,%.9g,%d", static_cast<double>(map->long_axis[v]),
                  static_cast<double>(map->angle_rad[v]), static_cast<int>(map->segment[v]));
      for (const auto& phase : map->thickness_mm) {
        std::printf(",%.9g", static_cast<double>(phase[v]));
      }
      std::printf("\n");
    }
  } catch (const beatlas::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
