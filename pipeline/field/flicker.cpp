#include "pipeline/field/flicker.h"

#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "runtime/base/cycle_modes.h"

namespace beatlas::field {
namespace {

constexpr std::size_t kFewestPhases = 8;
constexpr double kAroundMm = 6.0;  ///< neighbours lie within a cube of twice this edge
/// Below a tenth of what a package rounds nothing is taken off: exact shapes have 0.002 mm of their
/// own, images from 0.03 mm on.
constexpr double kLeastNoiseMm = 0.005;
constexpr double kNearMm = 3.0;  ///< noise is that of samples this near to the surface

/// The samples' course over the cycle as its modes, or back.
void turn(const std::vector<double>& modes, bool back, std::vector<std::vector<float>>& samples) {
  const std::size_t phases = samples.size();
  const std::size_t count = samples.front().size();
  constexpr std::size_t kValuesATask = 4096;
  parallel_for((count + kValuesATask - 1) / kValuesATask, [&](std::size_t block) {
    const std::size_t from = block * kValuesATask;
    const std::size_t size = std::min(kValuesATask, count - from);
    std::vector<float> out(phases * size, 0.0F);
    for (std::size_t r = 0; r < phases; ++r) {
      for (std::size_t p = 0; p < phases; ++p) {
        const auto weight =
            static_cast<float>(back ? modes[p * phases + r] : modes[r * phases + p]);
        const float* in = samples[p].data() + from;
        float* to = out.data() + r * size;
        for (std::size_t v = 0; v < size; ++v) to[v] += weight * in[v];
      }
    }
    for (std::size_t r = 0; r < phases; ++r) {
      std::copy_n(out.data() + r * size, size, samples[r].data() + from);
    }
  });
}

/// Sums over a window of 2 radius + 1 samples along one axis, beyond the lattice nothing.
void box_sum(const Grid& grid, int axis, int radius, std::vector<float>& values) {
  const auto a = static_cast<std::size_t>(axis);
  const auto stride = axis == 0   ? std::size_t{1}
                      : axis == 1 ? static_cast<std::size_t>(grid.size[0])
                                  : grid.slice_count();
  const int length = grid.size[a];
  const std::size_t lines = values.size() / static_cast<std::size_t>(length);
  const auto first_of = [&](std::size_t line) {
    return axis == 0 ? line * static_cast<std::size_t>(length)
                     : line / stride * stride * static_cast<std::size_t>(length) + line % stride;
  };
  constexpr std::size_t kLines = 256;
  parallel_for((lines + kLines - 1) / kLines, [&](std::size_t block) {
    std::vector<double> until(static_cast<std::size_t>(length) + 1);
    for (std::size_t line = block * kLines; line < std::min(lines, (block + 1) * kLines); ++line) {
      float* at = values.data() + first_of(line);
      until[0] = 0;
      for (int n = 0; n < length; ++n) {
        until[static_cast<std::size_t>(n) + 1] =
            until[static_cast<std::size_t>(n)] + at[static_cast<std::size_t>(n) * stride];
      }
      for (int n = 0; n < length; ++n) {
        const auto low = static_cast<std::size_t>(std::max(0, n - radius));
        const auto high = static_cast<std::size_t>(std::min(length, n + radius + 1));
        at[static_cast<std::size_t>(n) * stride] = static_cast<float>(until[high] - until[low]);
      }
    }
  });
}

/// Samples whose course over the cycle is one of the surface: one that the clamp cuts is none.
struct WholeCourses {
  std::vector<float> whole;       ///< [sample] 1 of a whole course, else 0
  std::vector<std::size_t> near;  ///< of these, the samples that come near to the surface
};

WholeCourses whole_courses(const FieldCycle& field) {
  const Grid& grid = field.distance_mm.grid;
  const auto inner = static_cast<float>(-field.inner_mm);
  const auto outer = static_cast<float>(field.outer_mm);
  WholeCourses out;
  out.whole.assign(grid.count(), 0.0F);
  std::vector<std::vector<std::size_t>> near_in(static_cast<std::size_t>(grid.size[2]));
  parallel_for(near_in.size(), [&](std::size_t k) {
    for (std::size_t v = k * grid.slice_count(); v < (k + 1) * grid.slice_count(); ++v) {
      float least = outer;
      float most = inner;
      for (const std::vector<float>& phase : field.distance_mm.phases) {
        least = std::min(least, phase[v]);
        most = std::max(most, phase[v]);
      }
      if (!(least > inner && most < outer)) continue;
      out.whole[v] = 1.0F;
      if (least < kNearMm && most > -kNearMm) near_in[k].push_back(v);
    }
  });
  for (const auto& slice : near_in) out.near.insert(out.near.end(), slice.begin(), slice.end());
  return out;
}

/// Mean over the cube around, of whole courses.
class MeanAround {
 public:
  /// @param whole [sample] 1 of a whole course, else 0; it must outlive this
  MeanAround(const Grid& grid, double voxel_mm, const std::vector<float>& whole)
      : grid_(grid),
        radius_(std::max(1, static_cast<int>(std::lround(kAroundMm / voxel_mm)))),
        whole_(whole),
        weight_(whole) {
    for (int axis = 0; axis < 3; ++axis) box_sum(grid_, axis, radius_, weight_);
  }

  [[nodiscard]] std::vector<float> operator()(std::vector<float> values) const {
    const std::size_t count = values.size();
    for (std::size_t v = 0; v < count; ++v) values[v] *= whole_[v];
    for (int axis = 0; axis < 3; ++axis) box_sum(grid_, axis, radius_, values);
    for (std::size_t v = 0; v < count; ++v) {
      values[v] = whole_[v] > 0 ? values[v] / weight_[v] : 0.0F;
    }
    return values;
  }

 private:
  const Grid& grid_;
  int radius_;
  const std::vector<float>& whole_;
  std::vector<float> weight_;
};

/// What each mode but the mean is beside its neighbours: twice the mean less the mean's mean
/// follows a course that bends with place, as the mean alone does not.
/// @param modes [mode][sample]; so is what is returned, of the mean nothing
std::vector<std::vector<float>> rough_modes(const std::vector<std::vector<float>>& modes,
                                            const std::vector<float>& whole,
                                            const MeanAround& around) {
  std::vector<std::vector<float>> rough(modes.size());
  parallel_for(modes.size() - 1, [&](std::size_t n) {
    const std::size_t r = n + 1;
    const std::vector<float> mean = around(modes[r]);
    rough[r] = around(mean);
    for (std::size_t v = 0; v < whole.size(); ++v) {
      rough[r][v] = whole[v] * (modes[r][v] - 2 * mean[v] + rough[r][v]);
    }
  });
  return rough;
}

/// [mm2] Variance of the noise in a mode. Noise is as strong in each of the highest modes, motion
/// weaker in each: the weakest tells. The median of a normal variable's square is 0.455 of its
/// mean.
/// @param rough [mode][sample]  @param near the samples that are asked
float noise_of(const std::vector<std::vector<float>>& rough, const std::vector<std::size_t>& near) {
  const std::size_t phases = rough.size();
  std::vector<float> noises(std::max<std::size_t>(2, phases / 4));
  parallel_for(noises.size(), [&](std::size_t n) {
    const std::vector<float>& mode = rough[phases - 1 - n];
    std::vector<float> squares(near.size());
    std::transform(near.begin(), near.end(), squares.begin(),
                   [&](std::size_t v) { return mode[v] * mode[v]; });
    const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
    std::nth_element(squares.begin(), middle, squares.end());
    noises[n] = *middle / 0.455F;
  });
  return *std::min_element(noises.begin(), noises.end());
}

}  // namespace

void take_off_flicker(FieldCycle& field) {
  std::vector<std::vector<float>>& samples = field.distance_mm.phases;
  const std::size_t phases = samples.size();
  if (phases < kFewestPhases) return;
  const WholeCourses courses = whole_courses(field);
  if (courses.near.empty()) return;
  const std::vector<float>& whole = courses.whole;
  const MeanAround around(field.distance_mm.grid, field.voxel_mm, whole);

  const std::vector<double> modes = cycle_modes(static_cast<int>(phases));
  std::vector<std::vector<float>> given(phases);
  parallel_for(phases, [&](std::size_t p) { given[p] = samples[p]; });
  turn(modes, false, samples);
  const std::vector<std::vector<float>> rough = rough_modes(samples, whole, around);
  const float noise = noise_of(rough, courses.near);
  if (noise < kLeastNoiseMm * kLeastNoiseMm) {
    samples = given;
    return;
  }
  const std::size_t count = whole.size();
  parallel_for(phases - 1, [&](std::size_t n) {
    const std::size_t r = n + 1;
    std::vector<float> power = rough[r];
    for (float& value : power) value *= value;
    power = around(std::move(power));
    for (std::size_t v = 0; v < count; ++v) {
      if (whole[v] == 0 || !(power[v] > 0)) continue;
      samples[r][v] -= std::min(1.0F, noise / power[v]) * rough[r][v];
    }
  });
  turn(modes, true, samples);
  const auto inner = static_cast<float>(-field.inner_mm);
  const auto outer = static_cast<float>(field.outer_mm);
  parallel_for(phases, [&](std::size_t p) {
    for (std::size_t v = 0; v < count; ++v) {
      samples[p][v] = whole[v] > 0 ? std::clamp(samples[p][v], inner, outer) : given[p][v];
    }
  });
}

}  // namespace beatlas::field
