#pragma once
/// What lies how far from the LV's cavity, in each sector of a slice.

#include <array>
#include <vector>

#include <Eigen/Core>

namespace beatlas::segment {

/// A wall is thick at one side and thin at another: it is told in sectors round the LV's middle.
/// What tells of one spans 70 degrees at half its weight, about a segment of the AHA's model
/// (Cerqueira et al., Circulation 105:539, 2002).
inline constexpr int kSectors = 12;
/// Several sectors are worked on at a time.
using BySector = Eigen::Array<double, kSectors, 1>;

/// What a place tells of each sector. @param at in sectors round the LV's middle
[[nodiscard]] BySector weights_by_sector(float at);

/// Shares of cavity, muscle and what is outside, by sector and by millimetres from the cavity's
/// outline. They are the mixture of the three looks that the images are likeliest from, on
/// condition that cavity and wall, going outward, end once each.
class WallLayers {
 public:
  using Shares = std::array<double, 3>;  ///< cavity, muscle, outside
  struct Voxel {
    int bin = 0;    ///< see bin_of
    Shares look{};  ///< densities of its intensity in each
    BySector weight = BySector::Zero();
  };

  /// @param signed_mm from the cavity's outline, negative inside
  [[nodiscard]] static int bin_of(float signed_mm);
  explicit WallLayers(const std::vector<Voxel>& voxels);
  /// Between the middles of two sectors shares go straight on. @param at see weights_by_sector
  [[nodiscard]] Shares at(float at, int bin) const;

 private:
  static constexpr int kBins = 60;
  using Sums = std::array<std::array<BySector, 3>, kBins>;
  void end_once(const Sums& sums, Eigen::Index s);

  Sums shares_;
};

}  // namespace beatlas::segment
