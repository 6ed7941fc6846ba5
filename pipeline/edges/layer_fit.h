#pragma once
/// A layer of fat between muscle and what lies beyond, told from intensities across an outline.

#include <array>
#include <cstddef>
#include <optional>

namespace beatlas::edges {

/// Means of intensities across an outline, inside first.
struct AcrossProfile {
  static constexpr double kFromPx = -8;
  static constexpr double kBinPx = 0.5;
  static constexpr std::size_t kBins = 24;

  std::array<double, kBins> mean{};
  std::array<double, kBins> weight{};  ///< voxels that tell it; 0: it does not count

  [[nodiscard]] static double middle_px(std::size_t bin) {
    return kFromPx + kBinPx * (static_cast<double>(bin) + 0.5);
  }
};

/// What the images as a whole say of the tissues.
struct LayerLevels {
  double muscle = 0;
  double blood = 0;
  double fat = 0;    ///< brighter than muscle
  double noise = 0;  ///< standard deviation, > 0
};

struct FatLayer {
  double edge_px = 0;        ///< where muscle ends, along the profile
  double thickness_px = 0;   ///< in the plane of the slice
  double edge_sigma_px = 0;  ///< of edge_px, by noise
};

/// Least squares of muscle, a layer of fat and one level beyond, box-shaped voxels. What is thinner
/// than a voxel shows only as a bright rim, or as an edge too far out: half a millimetre of fat
/// before lung moves the edge of muscle by two.
/// @return nothing where muscle and what lies beyond alone explain the profile, or where its inside
/// is no muscle
[[nodiscard]] std::optional<FatLayer> fit_fat_layer(const AcrossProfile& profile,
                                                    const LayerLevels& levels);

}  // namespace beatlas::edges
