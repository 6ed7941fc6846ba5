#include "pipeline/tissue/denoise.h"

#include <algorithm>
#include <array>

#include "pipeline/core/parallel.h"

namespace beatlas::tissue {
namespace {

constexpr int kDenoiseRounds = 5;
constexpr float kRate = 0.125F;  ///< of a round, for each of eight neighbours: stable
constexpr double kWidth = 2.0;   ///< of the noise, in the first round; it falls with the noise
constexpr double kFall = 0.8;    ///< of the width, a round

/// One round of diffusion.
struct Diffusion {
  std::array<float, 3> rate{};  ///< of what flows along each axis
  float rate_in_time = 0;
  float inverse_square = 0;  ///< of the width: conductance falls where neighbours differ by more

  /// What flows in from a neighbour that differs by so much.
  [[nodiscard]] float flow(float difference) const {
    return difference / (1 + difference * difference * inverse_square);
  }
};

/// Adds to a row what flows in from those a stride before and after it.
/// @param low, high whether there are such rows  @param target of the row `here`, `wide` long
void add_flow_across(Diffusion by, std::size_t axis, const float* here, std::size_t wide,
                     std::size_t stride, bool low, bool high, float* target) {
  const auto reach = static_cast<std::ptrdiff_t>(stride);
  const float rate = by.rate[axis];
  for (std::size_t v = 0; v < wide; ++v) {
    const float* at = here + v;
    float sum = 0;
    if (low) sum += by.flow(at[-reach] - *at);
    if (high) sum += by.flow(at[reach] - *at);
    target[v] += rate * sum;
  }
}

/// Adds to a row what flows within it.
void add_flow_along(Diffusion by, const float* here, std::size_t wide, float* target) {
  for (std::size_t v = 1; v < wide; ++v) {
    const float along = by.rate[0] * by.flow(here[v] - here[v - 1]);
    target[v] -= along;
    target[v - 1] += along;
  }
}

/// A slice of phase p after a round.
void diffuse_slice(Diffusion by, const ImageCycle<float>& now, std::size_t p, int k,
                   std::vector<float>& next) {
  const Grid& grid = now.grid;
  const std::size_t n = now.phases.size();
  const auto wide = static_cast<std::size_t>(grid.size[0]);
  for (int j = 0; j < grid.size[1]; ++j) {
    const std::size_t row = grid.offset(0, j, k);
    const float* here = now.phases[p].data() + row;
    const float* before = now.phases[(p + n - 1) % n].data() + row;
    const float* after = now.phases[(p + 1) % n].data() + row;
    float* target = next.data() + row;
    for (std::size_t v = 0; v < wide; ++v) {
      target[v] =
          here[v] + by.rate_in_time * (by.flow(before[v] - here[v]) + by.flow(after[v] - here[v]));
    }
    add_flow_along(by, here, wide, target);
    add_flow_across(by, 1, here, wide, wide, j > 0, j + 1 < grid.size[1], target);
    add_flow_across(by, 2, here, wide, grid.slice_count(), k > 0, k + 1 < grid.size[2], target);
  }
}

}  // namespace

ImageCycle<float> denoised(const ImageCycle<float>& images, double noise, double phase_step_mm) {
  ImageCycle<float> now{images.grid, images.phases};
  if (!(noise > 0)) return now;
  const Grid& grid = images.grid;
  const std::size_t n = images.phases.size();
  const Vec3 spacing = grid.spacing_mm();
  const double pixel = std::min(spacing[0], spacing[1]);
  Diffusion by;
  for (int a = 0; a < 3; ++a) {
    const double closeness = pixel / spacing[a];
    by.rate[static_cast<std::size_t>(a)] = kRate * static_cast<float>(closeness * closeness);
  }
  const double nearness = std::min(1.0, pixel / phase_step_mm);
  by.rate_in_time = kRate * static_cast<float>(nearness * nearness);
  ImageCycle<float> next{grid, std::vector<std::vector<float>>(n)};
  for (auto& phase : next.phases) phase.resize(grid.count());
  const auto slices = static_cast<std::size_t>(grid.size[2]);
  double width = kWidth * noise;
  for (int round = 0; round < kDenoiseRounds; ++round, width *= kFall) {
    by.inverse_square = static_cast<float>(1 / (width * width));
    parallel_for(n * slices, [&](std::size_t job) {
      const std::size_t p = job / slices;
      diffuse_slice(by, now, p, static_cast<int>(job % slices), next.phases[p]);
    });
    std::swap(now, next);
  }
  return now;
}

}  // namespace beatlas::tissue
