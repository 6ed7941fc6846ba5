#pragma once
/// Blood, muscle, fat and what lies beyond, told from intensities across the heart's surface in
/// space.

#include <array>
#include <cstddef>
#include <vector>

#include "pipeline/edges/layer_fit.h"
#include "runtime/base/geometry.h"

namespace beatlas::edges {

/// Means of intensities by how far outside of a surface voxels lie.
struct SurfaceProfile {
  static constexpr double kFromMm = -7;
  static constexpr double kBinMm = 0.5;
  static constexpr std::size_t kBins = 24;

  std::array<double, kBins> mean{};
  std::array<double, kBins> variance{};  ///< of the mean; 0: nothing is told

  [[nodiscard]] static constexpr double middle_mm(std::size_t bin) {
    return kFromMm + kBinMm * (static_cast<double>(bin) + 0.5);
  }
};

/// Thicknesses of fat that are tried [mm], of the 0.05 mm to which all ends are told.
inline constexpr std::array kFatThicknessMm{0.0, 0.1, 0.2, 0.35, 0.55, 0.85, 1.3, 2.0, 3.2, 5.0};

/// What explains a profile best, fat being so thick.
struct LayersAt {
  double edge_mm = 0;  ///< where the heart ends, outside of the profile's zero
  double wall_mm = 0;  ///< of muscle between blood and that edge; 0: none, blood comes to it
  double cost = 0;     ///< sum of squares, in variances
};

struct LayersByThickness {
  std::array<LayersAt, kFatThicknessMm.size()> at{};
  double edge_sigma_mm = 0;  ///< standard deviation by noise, at the best of them
};

/// Least squares of blood, a wall of muscle, a layer of fat and one level beyond, box-shaped voxels
/// cut by planes. A wall is no thinner than an atrium's or it is none. All known levels may be
/// brighter or darker together, as a coil's shading that is left makes them.
/// @param normal of the surface, along the grid's axes  @param spacing_mm of voxels
/// @param begin indices of kFatThicknessMm from which the search sets out, not empty
[[nodiscard]] LayersByThickness fit_layers(const SurfaceProfile& profile, const LayerLevels& levels,
                                           const Vec3& normal, const Vec3& spacing_mm,
                                           const std::vector<std::size_t>& begin);

}  // namespace beatlas::edges
