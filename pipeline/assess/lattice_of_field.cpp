#include "pipeline/assess/lattice_of_field.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace beatlas::assess {
namespace {

using atlas::FieldPayload;
constexpr auto kEdge = static_cast<std::size_t>(FieldPayload::kBlockEdge);

/// Coefficients of a phase, contracted in time, with one sample of the outside around the lattice.
struct Bordered {
  std::array<std::size_t, 3> size{};
  std::vector<float> counts;

  [[nodiscard]] std::size_t step(std::size_t axis) const {
    return axis == 0 ? 1 : axis == 1 ? size[0] : size[0] * size[1];
  }
};

/// Where rows of leaves hold a phase and those around it.
struct Times {
  std::size_t before = 0;
  std::size_t now = 0;
  std::size_t after = 0;
};

/// A block that is not wholly outside. @param corner of `out` where its first sample lies
void write_block(const FieldPayload& field, std::int32_t entry, const Times& times,
                 std::size_t corner, Bordered& out) {
  for (std::size_t z = 0; z < kEdge; ++z) {
    for (std::size_t y = 0; y < kEdge; ++y) {
      float* to = out.counts.data() + corner + y * out.step(1) + z * out.step(2);
      if (entry == FieldPayload::kInside) {
        std::fill_n(to, kEdge, static_cast<float>(field.clamp_count(true)));
        continue;
      }
      const std::int16_t* from =
          field.coefficients.data() + field.row_at(entry, static_cast<int>(y), static_cast<int>(z));
      for (std::size_t x = 0; x < kEdge; ++x) {
        to[x] = (static_cast<float>(from[times.before + x] + from[times.after + x]) +
                 4.F * static_cast<float>(from[times.now + x])) /
                6.F;
      }
    }
  }
}

Bordered contracted_in_time(const FieldPayload& field, std::size_t phase) {
  Bordered out;
  for (std::size_t a = 0; a < 3; ++a) {
    out.size[a] = static_cast<std::size_t>(field.block_count[a]) * kEdge + 2;
  }
  out.counts.assign(out.size[0] * out.size[1] * out.size[2],
                    static_cast<float>(field.clamp_count(false)));
  const auto phases = static_cast<std::size_t>(field.phases);
  const Times times{(phase + phases - 1) % phases * kEdge, phase * kEdge,
                    (phase + 1) % phases * kEdge};
  std::size_t block = 0;
  for (std::size_t bz = 1; bz < out.size[2] - 1; bz += kEdge) {
    for (std::size_t by = 1; by < out.size[1] - 1; by += kEdge) {
      for (std::size_t bx = 1; bx < out.size[0] - 1; bx += kEdge, ++block) {
        const std::int32_t entry = field.blocks[block];
        if (entry == FieldPayload::kOutside) continue;
        write_block(field, entry, times, bx + out.size[0] * (by + out.size[1] * bz), out);
      }
    }
  }
  return out;
}

/// 1/6, 4/6, 1/6 along an axis; the border stays as it is.
void smooth_along(const Bordered& grid, std::size_t axis, const std::vector<float>& from,
                  std::vector<float>& to) {
  const std::size_t step = grid.step(axis);
  for (std::size_t z = 1; z + 1 < grid.size[2]; ++z) {
    for (std::size_t y = 1; y + 1 < grid.size[1]; ++y) {
      const std::size_t row = grid.size[0] * (y + grid.size[1] * z);
      for (std::size_t at = row + 1; at + 1 < row + grid.size[0]; ++at) {
        to[at] = (from[at - step] + 4.F * from[at] + from[at + step]) / 6.F;
      }
    }
  }
}

/// Of the spline at a sample, in counts a sample.
Vec3 gradient_at(const Bordered& grid, std::size_t at) {
  constexpr std::array<double, 3> kValue{1.0 / 6, 4.0 / 6, 1.0 / 6};
  constexpr std::array<double, 3> kSlope{-0.5, 0, 0.5};
  Vec3 out = Vec3::Zero();
  const float* corner = grid.counts.data() + at - grid.step(2) - grid.step(1) - 1;
  for (std::size_t z = 0; z < 3; ++z) {
    for (std::size_t y = 0; y < 3; ++y) {
      for (std::size_t x = 0; x < 3; ++x) {
        const double c = corner[z * grid.step(2) + y * grid.step(1) + x];
        out += c * Vec3(kSlope[x] * kValue[y] * kValue[z], kValue[x] * kSlope[y] * kValue[z],
                        kValue[x] * kValue[y] * kSlope[z]);
      }
    }
  }
  return out;
}

}  // namespace

LatticeOfField lattice_of_field(const FieldPayload& field, std::size_t phase) {
  const Bordered grid = contracted_in_time(field, phase);
  // A pass reads neighbours along its own axis alone, so that the border, which no pass changes, is
  // the outside for each of them.
  std::vector<float> once = grid.counts;
  smooth_along(grid, 0, grid.counts, once);
  std::vector<float> twice = grid.counts;
  smooth_along(grid, 1, once, twice);
  smooth_along(grid, 2, twice, once);
  LatticeOfField out;
  for (std::size_t a = 0; a < 3; ++a) out.size[a] = static_cast<int>(grid.size[a] - 2);
  out.distance_mm.reserve(grid.counts.size());
  const double per_sample = field.step_mm / field.voxel_mm;
  for (std::size_t z = 1; z + 1 < grid.size[2]; ++z) {
    for (std::size_t y = 1; y + 1 < grid.size[1]; ++y) {
      for (std::size_t x = 1; x + 1 < grid.size[0]; ++x) {
        const std::size_t at = x + grid.size[0] * (y + grid.size[1] * z);
        const double mm = std::clamp(field.step_mm * static_cast<double>(once[at]), -field.inner_mm,
                                     field.outer_mm);
        out.distance_mm.push_back(static_cast<float>(mm));
        if (std::abs(mm) < 0.5 * field.voxel_mm) {
          out.slopes.push_back(static_cast<float>(per_sample * gradient_at(grid, at).norm()));
        }
      }
    }
  }
  return out;
}

}  // namespace beatlas::assess
