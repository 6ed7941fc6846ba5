#include "runtime/viewer/heart_mask.h"

#include <algorithm>
#include <cmath>

namespace beatlas::viewer {
namespace {

constexpr int kMoments = 8;     // of the beat, at which a voxel is looked at beforehand
constexpr double kStrayMm = 4;  // farther the surface does not stray between two of them
constexpr double kCountsPerMm = 100;
constexpr double kInwardMm = 0.5;      // the mask's middle lies this far within the surface
constexpr double kLeastHalfMm = 0.75;  // half the width over which it falls
// The field knows no distance beyond 6 mm: what falls more slowly would never reach zero, however
// far apart the slices are.
constexpr double kMostHalfMm = 2;

}  // namespace

HeartMask::HeartMask(const Affine& workspace_from_index, const std::array<int, 3>& size,
                     std::shared_ptr<const field::FieldQuery> heart)
    : heart_(std::move(heart)),
      half_mm_(std::clamp(0.5 * workspace_from_index.linear().colwise().norm().maxCoeff(),
                          kLeastHalfMm, kMostHalfMm)),
      mask_(static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
                static_cast<std::size_t>(size[2]),
            0) {
  std::size_t at = 0;
  for (int z = 0; z < size[2]; ++z) {
    for (int y = 0; y < size[1]; ++y) {
      for (int x = 0; x < size[0]; ++x, ++at) {
        const Vec3 place = workspace_from_index * Vec3(x, y, z);
        double least = heart_->sample(place, 0).distance_mm;
        double most = least;
        for (int moment = 1; moment < kMoments; ++moment) {
          const double t = heart_->rr_interval_s() * moment / kMoments;
          const double distance = heart_->sample(place, t).distance_mm;
          least = std::min(least, distance);
          most = std::max(most, distance);
        }
        if (share(least - kStrayMm) == 0) continue;
        if (share(most + kStrayMm) == 255) {
          mask_[at] = 255;
          continue;
        }
        edge_.push_back(static_cast<std::uint32_t>(at));
        places_mm_.push_back(place);
      }
    }
  }
}

std::uint8_t HeartMask::share(double distance_mm) const {
  const double share = 0.5 - (distance_mm + kInwardMm) / (2 * half_mm_);
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

// The distances of the voxels at the edge, once for each of some moments.
const std::vector<std::int16_t>& HeartMask::kept_at(int moment) {
  std::vector<std::int16_t>& kept = kept_[static_cast<std::size_t>(moment)];
  if (!kept.empty() || edge_.empty()) return kept;
  kept.reserve(edge_.size());
  const double t = heart_->rr_interval_s() * moment / kKept;
  for (const Vec3& place : places_mm_) {
    kept.push_back(static_cast<std::int16_t>(
        std::lround(kCountsPerMm * heart_->sample(place, t).distance_mm)));
  }
  return kept;
}

const std::vector<std::uint8_t>& HeartMask::at(double beats) {
  const double at = kKept * (beats - std::floor(beats));
  const int before = static_cast<int>(at) % kKept;
  const double u = at - std::floor(at);
  // Catmull and Rom's cubic through the four moments around it.
  const std::array<double, 4> weights{((2 - u) * u - 1) * u / 2, ((3 * u - 5) * u * u + 2) / 2,
                                      ((4 - 3 * u) * u + 1) * u / 2, (u - 1) * u * u / 2};
  std::array<const std::int16_t*, 4> kept{};
  for (int n = 0; n < 4; ++n) {
    kept[static_cast<std::size_t>(n)] = kept_at((before + n - 1 + kKept) % kKept).data();
  }
  for (std::size_t n = 0; n < edge_.size(); ++n) {
    const double counts = weights[0] * kept[0][n] + weights[1] * kept[1][n] +
                          weights[2] * kept[2][n] + weights[3] * kept[3][n];
    mask_[edge_[n]] = share(counts / kCountsPerMm);
  }
  return mask_;
}

}  // namespace beatlas::viewer
