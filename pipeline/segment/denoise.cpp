#include "pipeline/segment/denoise.h"

#include <algorithm>
#include <array>

#include "pipeline/core/parallel.h"

namespace beatlas::segment {
namespace {

constexpr int kDenoiseRounds = 5;
constexpr float kRate = 0.125F;  ///< of a round, for each of eight neighbours: stable
constexpr double kWidth = 2.0;   ///< of the noise, in the first round; it falls with the noise
constexpr double kFall = 0.8;    ///< of the width, a round

}  // namespace

ImageCycle<float> denoised(const ImageCycle<float>& images, double noise, double phase_step_mm) {
  ImageCycle<float> now{images.grid, images.phases};
  if (!(noise > 0)) return now;
  const Grid& grid = images.grid;
  const std::size_t n = images.phases.size();
  const Vec3 spacing = grid.spacing_mm();
  const double pixel = std::min(spacing[0], spacing[1]);
  std::array<float, 3> rate{};
  for (int a = 0; a < 3; ++a) {
    const double closeness = pixel / spacing[a];
    rate[static_cast<std::size_t>(a)] = kRate * static_cast<float>(closeness * closeness);
  }
  const double nearness = std::min(1.0, pixel / phase_step_mm);
  const float rate_in_time = kRate * static_cast<float>(nearness * nearness);
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(grid.size[0]),
                                          grid.slice_count()};
  ImageCycle<float> next{grid, std::vector<std::vector<float>>(n)};
  for (auto& phase : next.phases) phase.resize(grid.count());
  double width = kWidth * noise;
  for (int round = 0; round < kDenoiseRounds; ++round, width *= kFall) {
    const auto inverse = static_cast<float>(1 / (width * width));
    const auto slices = static_cast<std::size_t>(grid.size[2]);
    parallel_for(n * slices, [&](std::size_t job) {
      const std::size_t p = job / slices;
      const auto k = static_cast<int>(job % slices);
      const float* here = now.phases[p].data();
      const float* before = now.phases[(p + n - 1) % n].data();
      const float* after = now.phases[(p + 1) % n].data();
      float* target = next.phases[p].data();
      const auto flow = [inverse](float difference) {
        return difference / (1 + difference * difference * inverse);
      };
      for (int j = 0; j < grid.size[1]; ++j) {
        const std::size_t row = grid.offset(0, j, k);
        const auto cross = [&](std::size_t a, bool low, bool high) {
          for (std::size_t v = row; v < row + stride[1]; ++v) {
            float sum = 0;
            if (low) sum += flow(here[v - stride[a]] - here[v]);
            if (high) sum += flow(here[v + stride[a]] - here[v]);
            target[v] += rate[a] * sum;
          }
        };
        for (std::size_t v = row; v < row + stride[1]; ++v) {
          target[v] =
              here[v] + rate_in_time * (flow(before[v] - here[v]) + flow(after[v] - here[v]));
        }
        for (std::size_t v = row + 1; v < row + stride[1]; ++v) {
          const float along = rate[0] * flow(here[v] - here[v - 1]);
          target[v] -= along;
          target[v - 1] += along;
        }
        cross(1, j > 0, j + 1 < grid.size[1]);
        cross(2, k > 0, k + 1 < grid.size[2]);
      }
    });
    std::swap(now, next);
  }
  return now;
}

}  // namespace beatlas::segment
