#include "runtime/viewer/heart_mask.h"

#include <algorithm>
#include <cmath>

namespace beatlas::viewer {
namespace {

constexpr int kMoments = 8;            // of the beat, at which a voxel is looked at beforehand
constexpr double kBetweenMm = 4;       // farther the surface does not stray between two of them
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
        if (share(least - kBetweenMm) == 0) continue;
        if (share(most + kBetweenMm) == 255) {
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

const std::vector<std::uint8_t>& HeartMask::at(double beats) {
  const double t = beats * heart_->rr_interval_s();
  for (std::size_t n = 0; n < edge_.size(); ++n) {
    mask_[edge_[n]] = share(heart_->sample(places_mm_[n], t).distance_mm);
  }
  return mask_;
}

}  // namespace beatlas::viewer
