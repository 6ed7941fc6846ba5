#include "runtime/viewer/wall_colours.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::viewer {
namespace {

constexpr std::array<Rgb, 9> kViridis{{{68, 1, 84},
                                       {71, 45, 123},
                                       {59, 82, 139},
                                       {44, 114, 142},
                                       {33, 145, 140},
                                       {40, 174, 128},
                                       {94, 201, 98},
                                       {173, 220, 48},
                                       {253, 231, 37}}};

// Anterior, anteroseptal, inferoseptal, inferior, inferolateral, anterolateral.
constexpr std::array<Rgb, 6> kSectors{
    {{213, 94, 0}, {86, 180, 233}, {0, 114, 178}, {230, 159, 0}, {0, 158, 115}, {204, 121, 167}}};
constexpr Rgb kApex{240, 228, 66};

Rgb mixed(const Rgb& one, const Rgb& other, double share) {
  Rgb out{};
  for (std::size_t n = 0; n < 3; ++n) {
    out[n] = static_cast<std::uint8_t>(std::lround((1 - share) * one[n] + share * other[n]));
  }
  return out;
}

/// From the value that 1 % are below to the one that 1 % are above, to whole numbers outward.
ColourScale scale_of(std::string title, std::vector<double> values) {
  ColourScale scale{.title = std::move(title)};
  if (values.empty()) return scale;
  const auto at = [&](double share) {
    const auto n = std::lround(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + n, values.end());
    return values[static_cast<std::size_t>(n)];
  };
  scale.low = std::floor(at(0.01));
  scale.high = std::max(std::ceil(at(0.99)), scale.low + 1);
  return scale;
}

}  // namespace

ColourBy colouring_of(const std::string& word) {
  for (std::size_t n = 0; n < kColourings.size(); ++n) {
    if (word == kColourings[n]) return static_cast<ColourBy>(n);
  }
  throw Error(ErrorCode::Usage,
              "--colour must be structure, thickness, stiffness or segments, not " + word);
}

Rgb colour_of_share(double share) noexcept {
  const double at = std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0) *
                    static_cast<double>(kViridis.size() - 1);
  const auto n = std::min(static_cast<std::size_t>(at), kViridis.size() - 2);
  return mixed(kViridis[n], kViridis[n + 1], at - static_cast<double>(n));
}

Rgb colour_of_segment(int segment) noexcept {
  if (segment == 17) return kApex;
  if (segment <= 6) return mixed(kSectors[static_cast<std::size_t>(segment - 1)], {0, 0, 0}, 0.35);
  if (segment <= 12) return kSectors[static_cast<std::size_t>(segment - 7)];
  constexpr std::array<std::size_t, 4> kApical{0, 1, 3, 4};  // anterior, septal, inferior, lateral
  return mixed(kSectors[kApical[static_cast<std::size_t>(segment - 13)]], {255, 255, 255}, 0.5);
}

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
  if (by == ColourBy::Thickness) scale_ = scale_of("Wall [mm]", std::move(values));
  if (by == ColourBy::Stiffness) scale_ = scale_of("Stiffness [N/m]", std::move(values));
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

void WallColours::colours_at(Structure structure, double beats, std::vector<Rgb>& colours) const {
  const atlas::SurfaceMapPayload& map = *map_of(structure);
  const std::size_t phases = map.thickness_mm.size();
  const double at = (beats - std::floor(beats)) * static_cast<double>(phases);
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

double coloured_opacity(Structure structure) noexcept {
  if (structure == Structure::Heart) return 0;
  return structure == Structure::RvBlood || is_beyond_base(structure) ? 0.3 : 1;
}

std::vector<double> scale_marks(const ColourScale& scale, int most) {
  const double least_step = (scale.high - scale.low) / std::max(1, most);
  const double power = std::pow(10.0, std::floor(std::log10(least_step)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= least_step * (1 - 1e-9)) step = factor * power;
  }
  std::vector<double> marks;
  for (double n = std::ceil(scale.low / step - 1e-9); n * step <= scale.high + 1e-9 * step; ++n) {
    marks.push_back(n * step);
  }
  return marks;
}

}  // namespace beatlas::viewer
