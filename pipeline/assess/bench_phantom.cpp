#include "pipeline/assess/bench_phantom.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/core/parallel.h"

namespace beatlas::assess {
namespace {

constexpr int kBlock = 6;
constexpr double kSamples = 5;

Grid lattice_of(const phantom::Phantom& phantom, Structure structure,
                const Affine& workspace_from_lps, double sample_mm, double margin_mm) {
  constexpr double kSpacingMm = 4;  // samples may stop this short of an extreme
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (int p = 0; p < phantom.spec().phases; ++p) {
    const auto frame = phantom.frame(phantom.phase_time_s(p));
    for (const Vec3& lps : frame->sample_surface(structure, kSpacingMm)) {
      const Vec3 x = workspace_from_lps * lps;
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
  }
  Grid grid;
  const Vec3 first = ((low.array() - margin_mm - kSpacingMm) / sample_mm).floor();
  const Vec3 last = ((high.array() + margin_mm + kSpacingMm) / sample_mm).ceil();
  for (int axis = 0; axis < 3; ++axis) {
    grid.size[static_cast<std::size_t>(axis)] = static_cast<int>(last[axis] - first[axis]) + 1;
  }
  grid.mm_from_index.linear() *= sample_mm;
  grid.mm_from_index.translation() = sample_mm * first;
  return grid;
}

}  // namespace

phantom::PhantomSpec scaled_matrix(phantom::PhantomSpec spec, double factor) {
  Index3 size = spec.grid.size;
  for (int& n : size) n = std::max(1, static_cast<int>(std::lround(n * factor)));
  spec.scanner.slice_thickness_mm *= static_cast<double>(spec.grid.size[2]) / size[2];
  spec.grid = phantom::on_matrix(spec.grid, size, Vec3::Zero());
  return spec;
}

ShapeCycle exact_shape(const phantom::Phantom& phantom, Structure structure,
                       const Affine& workspace_from_lps, double sample_mm, double margin_mm,
                       StageContext& context) {
  ShapeCycle out;
  out.structure = structure;
  Grid& grid = out.level.grid;
  grid = lattice_of(phantom, structure, workspace_from_lps, sample_mm, margin_mm);
  const Affine lps_from_workspace = workspace_from_lps.inverse(Eigen::Isometry);
  const double band_mm = kSamples * sample_mm;
  Index3 blocks{};
  for (std::size_t a = 0; a < 3; ++a) blocks[a] = (grid.size[a] + kBlock - 1) / kBlock;
  const auto block_count = static_cast<std::size_t>(blocks[0]) *
                           static_cast<std::size_t>(blocks[1]) *
                           static_cast<std::size_t>(blocks[2]);
  for (int p = 0; p < phantom.spec().phases; ++p) {
    context.check_cancelled();
    const auto frame = phantom.frame(phantom.phase_time_s(p));
    std::vector<float> level(grid.count());
    parallel_for(block_count, [&](std::size_t n) {
      const int block = static_cast<int>(n);
      const Index3 first{kBlock * (block % blocks[0]), kBlock * (block / blocks[0] % blocks[1]),
                         kBlock * (block / (blocks[0] * blocks[1]))};
      Index3 end{};
      for (std::size_t a = 0; a < 3; ++a) end[a] = std::min(first[a] + kBlock, grid.size[a]);
      const auto distance = [&](double i, double j, double k) {
        return frame->distance_mm(structure, lps_from_workspace * grid.mm(i, j, k));
      };
      // A distance changes by no more than the way.
      const double middle = distance(first[0] + 0.5 * (kBlock - 1), first[1] + 0.5 * (kBlock - 1),
                                     first[2] + 0.5 * (kBlock - 1));
      const double reach = 0.5 * std::sqrt(3.0) * (kBlock - 1) * sample_mm;
      const bool far = std::abs(middle) > band_mm + reach;
      for (int k = first[2]; k < end[2]; ++k) {
        for (int j = first[1]; j < end[1]; ++j) {
          for (int i = first[0]; i < end[0]; ++i) {
            const double value = far ? middle : distance(i, j, k);
            level[grid.offset(i, j, k)] = static_cast<float>(std::clamp(value, -band_mm, band_mm));
          }
        }
      }
    });
    out.level.phases.push_back(std::move(level));
    context.progress((p + 1.0) / phantom.spec().phases);
  }
  return out;
}

}  // namespace beatlas::assess
