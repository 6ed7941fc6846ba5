#include "pipeline/phantom/drawn_scene.h"

#include <algorithm>
#include <array>

namespace beatlas::phantom {

Tissue DrawnScene::heart_at(const Vec3F& lps, const DrawnHeart::Moment& moment) const {
  if (heart == nullptr || lps.squaredNorm() > heart_reach * heart_reach) return Tissue::Outside;
  return heart->at(axes.transpose() * lps + heart_middle, moment);
}

std::vector<std::uint8_t> near_heart(const DrawnScene& scene, const DrawnStack& stack, int k,
                                     const Eigen::Vector2f& shift, float half_mm) {
  constexpr int kCell = 4;
  const int n = stack.columns;
  std::vector<std::uint8_t> out(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
  if (scene.heart == nullptr) return out;
  const std::array<DrawnHeart::Moment, 3> moments{scene.heart->moment(0), scene.heart->moment(0.5F),
                                                  scene.heart->moment(1)};
  const auto holds = [&](int i, int j) {
    const Vec3F lps =
        stack.seen_at(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k), shift);
    for (const float way : {0.0F, 1.0F, -1.0F}) {
      for (const DrawnHeart::Moment& moment : moments) {
        if (scene.heart_at(lps + way * half_mm * stack.normal, moment) != Tissue::Outside) {
          return true;
        }
      }
    }
    return false;
  };
  for (int j = kCell / 2; j < n + kCell / 2; j += kCell) {
    for (int i = kCell / 2; i < n + kCell / 2; i += kCell) {
      if (!holds(i, j)) continue;
      // The cell about this place, and those beside it.
      constexpr int kAround = kCell + kCell / 2;
      for (int y = std::max(0, j - kAround); y < std::min(n, j + kAround); ++y) {
        for (int x = std::max(0, i - kAround); x < std::min(n, i + kAround); ++x) {
          out[static_cast<std::size_t>(y) * static_cast<std::size_t>(n) +
              static_cast<std::size_t>(x)] = 1;
        }
      }
    }
  }
  return out;
}

}  // namespace beatlas::phantom
