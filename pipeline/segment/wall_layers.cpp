#include "pipeline/segment/wall_layers.h"

#include <algorithm>
#include <cmath>

namespace beatlas::segment {
namespace {

/// What all round the slice tells of each sector; without it a wall goes on into liver that looks
/// as it does. Measured on seeds of real exams: 0 to 0.4 make .02 of muscle's Dice.
constexpr double kAllRound = 0.1;
constexpr int kInside = 10;  ///< [mm] that are told apart on the inner side
constexpr int kRounds = 20;  ///< of expectation and maximisation

}  // namespace

BySector weights_by_sector(float at) {
  BySector out;
  for (int s = 0; s < kSectors; ++s) {
    const double off = std::remainder(static_cast<double>(at) - s - 0.5, kSectors);
    out[s] = kAllRound + (1 - kAllRound) * std::exp(-0.5 * off * off);
  }
  return out;
}

int WallLayers::bin_of(float signed_mm) {
  return std::clamp(static_cast<int>(std::lround(signed_mm)) + kInside, 0, kBins - 1);
}

WallLayers::WallLayers(const std::vector<Voxel>& voxels) {
  for (auto& bin : shares_) bin.fill(BySector::Constant(1.0 / 3));
  for (int round = 0; round < kRounds; ++round) {
    Sums sums;
    for (auto& bin : sums) bin.fill(BySector::Zero());
    for (const Voxel& voxel : voxels) {
      const auto n = static_cast<std::size_t>(voxel.bin);
      const auto& [cavity, muscle, outside] = shares_[n];
      const auto& [of_cavity, of_muscle, of_outside] = voxel.look;
      const BySector of_likely =
          voxel.weight / (cavity * of_cavity + muscle * of_muscle + outside * of_outside);
      for (std::size_t c = 0; c < 3; ++c) sums[n][c] += shares_[n][c] * voxel.look[c] * of_likely;
    }
    for (Eigen::Index s = 0; s < kSectors; ++s) end_once(sums, s);
  }
}

WallLayers::Shares WallLayers::at(float at, int bin) const {
  const auto& share = shares_[static_cast<std::size_t>(bin)];
  const double from = static_cast<double>(at) - 0.5 + kSectors;
  const auto low = static_cast<Eigen::Index>(from);
  const double t = from - static_cast<double>(low);
  Shares out{};
  for (std::size_t c = 0; c < out.size(); ++c) {
    out[c] = share[c][low % kSectors] * (1 - t) + share[c][(low + 1) % kSectors] * t;
  }
  return out;
}

/// Shares of a sector from what was summed up, cavity and wall growing no more outward.
void WallLayers::end_once(const Sums& sums, Eigen::Index s) {
  double within = 1;
  double blood = 1;
  for (std::size_t b = 0; b < kBins; ++b) {
    const double sum = sums[b][0][s] + sums[b][1][s] + sums[b][2][s];
    if (sum <= 0) continue;
    const double wall = std::min(within, 1 - sums[b][2][s] / sum);
    blood = std::min(blood, sums[b][0][s] / sum);
    shares_[b][0][s] = blood;
    shares_[b][1][s] = std::max(wall - blood, 0.0);
    shares_[b][2][s] = 1 - wall;
    within = wall;
  }
}

}  // namespace beatlas::segment
