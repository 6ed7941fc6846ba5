#include "runtime/viewer/surface_colours.h"

#include <algorithm>
#include <cmath>
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

}  // namespace

ColourBy colouring_of(const std::string& word) {
  for (std::size_t n = 0; n < kColourings.size(); ++n) {
    if (word == kColourings[n]) return static_cast<ColourBy>(n);
  }
  throw Error(
      ErrorCode::Usage,
      "--colour must be structure, thickness, stiffness, segments or uncertainty, not " + word);
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

double coloured_opacity(ColourBy by, Structure structure) noexcept {
  if (by == ColourBy::Uncertainty) return 1;
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
