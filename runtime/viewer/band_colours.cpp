#include "runtime/viewer/band_colours.h"

#include <utility>

namespace beatlas::viewer {

BandColours::BandColours(const std::vector<Banded>& surfaces) {
  std::vector<double> widths_mm;
  for (const Banded& surface : surfaces) {
    bands_.emplace(surface.structure, surface.band);
    std::vector<Vec3f> positions(surface.motion->vertex_count());
    std::vector<Vec3f> normals(positions.size());
    const std::size_t phases = surface.motion->surface().positions.size();
    for (std::size_t p = 0; p < phases; ++p) {
      const double beats = static_cast<double>(p) / static_cast<double>(phases);
      surface.motion->positions_at(beats, positions);
      surface.motion->normals_of(positions, normals);
      for (std::size_t v = 0; v < positions.size(); ++v) {
        widths_mm.push_back(surface.band.half_width_mm(positions[v].cast<double>(),
                                                       normals[v].cast<double>(), beats));
      }
    }
  }
  scale_ = scale_of("True within +- [mm]", std::move(widths_mm));
}

void BandColours::colours_of(const DrawnSurface& surface, std::vector<Rgb>& colours) const {
  const atlas::BandQuery& band = bands_.at(surface.structure);
  colours.resize(surface.positions.size());
  for (std::size_t v = 0; v < colours.size(); ++v) {
    colours[v] = scale_.colour_of(band.half_width_mm(
        surface.positions[v].cast<double>(), surface.normals[v].cast<double>(), surface.beats));
  }
}

}  // namespace beatlas::viewer
