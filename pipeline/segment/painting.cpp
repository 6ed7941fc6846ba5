#include "pipeline/segment/painting.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/core/parallel.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

/// Radius of seeds that mark no more than the voxels their line crosses.
constexpr double kThinMm = 0.1;

/// Offset of the voxel a place [indices] lies in; grid.count() outside.
std::size_t voxel_at(const Grid& grid, const Vec3& at) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(at[axis] > -0.5 && at[axis] < grid.size[static_cast<std::size_t>(axis)] - 0.5)) {
      return grid.count();
    }
  }
  return grid.offset(static_cast<int>(std::lround(at[0])), static_cast<int>(std::lround(at[1])),
                     static_cast<int>(std::lround(at[2])));
}

/// The range of indices of one grid, widened by a voxel, that holds places of another.
struct Range {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::max());
  Vec3 high = Vec3::Constant(std::numeric_limits<double>::lowest());

  void add(const Vec3& at) {
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  [[nodiscard]] int first(int axis) const {
    return static_cast<int>(std::ceil(std::clamp(low[axis] - 1, 0.0, 1e9)));
  }
  [[nodiscard]] int last(int axis, int size) const {
    return static_cast<int>(std::floor(std::clamp(high[axis] + 1, -1.0, size - 1.0)));
  }
};

/// What was painted in one image, on the grid of the images.
struct PaintedMarks {
  std::vector<std::uint8_t> labels;  ///< of each voxel's nearest painted centre in it
  Range range;                       ///< of voxels that may be painted
};

PaintedMarks marks_of_painting(const Grid& painted_grid, const std::vector<std::uint8_t>& painted,
                               const Grid& grid) {
  PaintedMarks out;
  out.labels.assign(grid.count(), kNotPainted);
  std::vector<float> away2(grid.count(), std::numeric_limits<float>::max());
  const Affine index_from_painted = grid.mm_from_index.inverse() * painted_grid.mm_from_index;
  const Vec3 half = 0.5 * index_from_painted.linear().cwiseAbs().rowwise().sum();
  for_each_voxel(painted_grid, [&](int i, int j, int k, std::size_t from) {
    if (painted[from] == kNotPainted) return;
    const Vec3 at = index_from_painted * Vec3(i, j, k);
    out.range.add(at - half);
    out.range.add(at + half);
    const std::size_t v = voxel_at(grid, at);
    if (v == grid.count()) return;
    const Vec3 off(at[0] - std::round(at[0]), at[1] - std::round(at[1]), at[2] - std::round(at[2]));
    const auto d2 = static_cast<float>(off.cwiseProduct(grid.spacing_mm()).squaredNorm());
    if (d2 < away2[v]) {
      away2[v] = d2;
      out.labels[v] = painted[from];
    }
  });
  return out;
}

/// Calls visit(label, begin, end) for each run of one label among the indices first..last of a row,
/// those of kNotPainted left out.
/// @param label_at called with an index
template <class LabelAt, class Visit>
void for_label_runs(int first, int last, const LabelAt& label_at, const Visit& visit) {
  std::uint8_t open = kNotPainted;
  int begin = first;
  for (int i = first; i <= last + 1; ++i) {
    const std::uint8_t label = i <= last ? label_at(i) : kNotPainted;
    if (label == open) continue;
    if (open != kNotPainted) visit(open, begin, i);
    open = label;
    begin = i;
  }
}

}  // namespace

std::vector<Seed> seeds_of_painting(const Grid& painted_grid,
                                    const std::vector<std::uint8_t>& painted, int phase,
                                    const Grid& grid) {
  const Affine painted_from_index = painted_grid.mm_from_index.inverse() * grid.mm_from_index;
  const PaintedMarks marks = marks_of_painting(painted_grid, painted, grid);
  const Range& range = marks.range;
  std::vector<Seed> seeds;
  for (int k = range.first(2); k <= range.last(2, grid.size[2]); ++k) {
    for (int j = range.first(1); j <= range.last(1, grid.size[1]); ++j) {
      const auto label_at = [&](int i) {
        const std::size_t within = voxel_at(painted_grid, painted_from_index * Vec3(i, j, k));
        const bool is_painted = within < painted.size() && painted[within] != kNotPainted;
        return is_painted ? painted[within] : marks.labels[grid.offset(i, j, k)];
      };
      const auto add = [&](std::uint8_t label, int begin, int end) {
        Seed run{ventricles_apart(label), grid.mm(begin, j, k), kThinMm, phase, {}, true};
        if (end - 1 > begin) run.stroke_lps_mm.push_back(grid.mm(end - 1, j, k));
        seeds.push_back(std::move(run));
      };
      for_label_runs(range.first(0), range.last(0, grid.size[0]), label_at, add);
    }
  }
  return seeds;
}

LabelCycle labels_on_grid(const LabelCycle& given, const Grid& grid,
                          const std::vector<Vec2>& drawn_shifted_mm) {
  const auto slices = static_cast<std::size_t>(grid.size[2]);
  if (!drawn_shifted_mm.empty() && drawn_shifted_mm.size() != slices) {
    throw_invalid("there are " + std::to_string(drawn_shifted_mm.size()) + " shifts for " +
                  std::to_string(slices) + " slices; give one a slice");
  }
  const Vec3 spacing = grid.spacing_mm();
  LabelCycle out{grid, {}};
  out.phases.assign(given.phases.size(), std::vector<std::uint8_t>(grid.count(), 0));
  const Affine given_from_index = given.grid.mm_from_index.inverse() * grid.mm_from_index;
  parallel_for(slices, [&](std::size_t slice) {
    const int k = static_cast<int>(slice);
    Vec3 shift = Vec3::Zero();  // [indices]
    if (!drawn_shifted_mm.empty()) {
      shift.head<2>() = drawn_shifted_mm[slice].cwiseQuotient(spacing.head<2>());
    }
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const std::size_t from = voxel_at(given.grid, given_from_index * (Vec3(i, j, k) + shift));
        if (from == given.grid.count()) continue;
        const std::size_t to = grid.offset(i, j, k);
        for (std::size_t p = 0; p < given.phases.size(); ++p) {
          out.phases[p][to] = given.phases[p][from];
        }
      }
    }
  });
  return out;
}

}  // namespace beatlas::segment
