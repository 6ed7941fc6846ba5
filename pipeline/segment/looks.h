#pragma once
/// What tissues look like: densities of intensity, a histogram of a few bins each.

#include <array>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/segment/competition.h"

namespace beatlas::segment {

inline constexpr int kLookBins = 64;

/// Intensities' place among bins that end at the images' 99.5th percentile.
class Bins {
 public:
  explicit Bins(const ImageCycle<float>& images);
  [[nodiscard]] std::size_t of(float value) const;
  [[nodiscard]] double width() const { return static_cast<double>(top_) / kLookBins; }

 private:
  float top_ = 1;
};

/// [bin]; 1: as frequent as if all bins were alike.
using Look = std::array<double, kLookBins>;
/// [label]
using Looks = std::array<Look, VoxelPrices::kLabels>;

/// Densities from counts, smoothed over two bins to each side or, if `sigma` is more [bins], by a
/// Gaussian of it. Counts of nothing give the density of bins that are all alike.
[[nodiscard]] Look density_of(const Look& counts, double sigma = 0);
[[nodiscard]] Looks densities_of(const Looks& counts);

/// What a millimetre costs labels of these weights (of probabilities, of any sum): by so much the
/// more as they are less likely. @param price of VoxelPrices, of one voxel
void set_prices(const std::array<double, VoxelPrices::kLabels>& weights, std::uint8_t* price);

}  // namespace beatlas::segment
