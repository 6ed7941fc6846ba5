#include "runtime/viewer/wall_colours.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace beatlas::viewer {

WallColours::WallColours(std::vector<std::shared_ptr<const atlas::SurfaceMapPayload>> maps,
                         ColourBy by, const palpation::PalpationParameters& parameters)
    : maps_(std::move(maps)), by_(by), parameters_(parameters) {
  if (by != ColourBy::Thickness) {
    std::erase_if(maps_, [](const auto& map) { return map->structure == Structure::RvBlood; });
  }
  std::vector<double> values;
  for (const auto& map : maps_) {
    for (const std::vector<float>& phase : map->thickness_mm) {
      for (std::size_t v = 0; v < phase.size(); ++v) {
        if (!(phase[v] > 0)) continue;
        values.push_back(by == ColourBy::Thickness ? static_cast<double>(phase[v])
                                                   : stiffness_n_per_m(*map, v));
      }
      if (by != ColourBy::Thickness) break;  // the same in every phase
    }
  }
  if (by != ColourBy::Thickness && by != ColourBy::Stiffness) return;
  scale_ = scale_of(by == ColourBy::Thickness ? "Wall [mm]" : "Stiffness [N/m]", std::move(values));
}

const atlas::SurfaceMapPayload* WallColours::map_of(Structure structure) const {
  const auto found = std::find_if(maps_.begin(), maps_.end(),
                                  [&](const auto& map) { return map->structure == structure; });
  return found == maps_.end() ? nullptr : found->get();
}

bool WallColours::has(Structure structure) const {
  return by_ != ColourBy::Structure && map_of(structure) != nullptr;
}

double WallColours::stiffness_n_per_m(const atlas::SurfaceMapPayload& map, std::size_t v) const {
  return parameters_.at(static_cast<double>(map.long_axis[v]), map.segment[v]).k_v_n_per_m;
}

void WallColours::colours_of(const DrawnSurface& surface, std::vector<Rgb>& colours) const {
  const atlas::SurfaceMapPayload& map = *map_of(surface.structure);
  const std::size_t phases = map.thickness_mm.size();
  const double at = (surface.beats - std::floor(surface.beats)) * static_cast<double>(phases);
  const auto p = std::min(static_cast<std::size_t>(at), phases - 1);
  const auto share = static_cast<float>(at - static_cast<double>(p));
  const std::vector<float>& now = map.thickness_mm[p];
  const std::vector<float>& next = map.thickness_mm[(p + 1) % phases];
  colours.resize(map.segment.size());
  for (std::size_t v = 0; v < colours.size(); ++v) {
    const float wall_mm = now[v] > 0 && next[v] > 0 ? (1 - share) * now[v] + share * next[v]
                                                    : std::max(now[v], next[v]);
    if (!(wall_mm > 0)) {
      colours[v] = kNoWall;
    } else if (by_ == ColourBy::Thickness) {
      colours[v] = scale_.colour_of(static_cast<double>(wall_mm));
    } else if (by_ == ColourBy::Stiffness) {
      colours[v] = scale_.colour_of(stiffness_n_per_m(map, v));
    } else {
      colours[v] = colour_of_segment(map.segment[v]);
    }
  }
}

}  // namespace beatlas::viewer
