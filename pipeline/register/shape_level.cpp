#include "pipeline/register/shape_level.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/core/cubic_convolution.h"
#include "pipeline/register/smooth_level.h"
#include "pipeline/register/sub_slices.h"

namespace beatlas::reg {

AxisMap axis_map(const Grid& source, const Grid& lattice, const Affine& workspace_from_lps) {
  const Affine index_from_lattice =
      source.mm_from_index.inverse() * workspace_from_lps.inverse() * lattice.mm_from_index;
  return {index_from_lattice.linear().diagonal(), index_from_lattice.translation()};
}

float sample_plane(const float* slice, int nx, int ny, double i, double j) {
  const double x = std::clamp(i, 0.0, nx - 1.0);
  const double y = std::clamp(j, 0.0, ny - 1.0);
  const int x0 = std::min(static_cast<int>(x), std::max(0, nx - 2));
  const int y0 = std::min(static_cast<int>(y), std::max(0, ny - 2));
  const auto u = static_cast<float>(x - x0);
  const auto v = static_cast<float>(y - y0);
  const float* row0 = slice + static_cast<std::ptrdiff_t>(y0) * nx + x0;
  const float* row1 = ny > 1 ? row0 + nx : row0;
  const int right = nx > 1 ? 1 : 0;
  return (1 - v) * ((1 - u) * row0[0] + u * row0[right]) +
         v * ((1 - u) * row1[0] + u * row1[right]);
}

namespace {

constexpr float kFar = 20.0F;  ///< [mm] level where there is nothing

/// Cubic convolution (pipeline/core/cubic_convolution.h) along one axis: four neighbours and their
/// weights for every lattice index, the outermost samples going on beyond the rim, or nothing where
/// it `ends`.
struct Taps {
  std::array<int, 4> at{};
  std::array<float, 4> weight{};
};
std::vector<Taps> cubic_taps(const AxisMap& map, int axis, int lattice_size, int source_size,
                             bool ends = false) {
  std::vector<Taps> out(static_cast<std::size_t>(lattice_size));
  for (int n = 0; n < lattice_size; ++n) {
    const double x = map.index(axis, n);
    if (ends && (x < -0.5 || x > source_size - 0.5)) continue;
    const double low = std::floor(x);
    const std::array<double, 4> weight = cubic_weights(x - low);
    Taps& taps = out[static_cast<std::size_t>(n)];
    for (std::size_t t = 0; t < 4; ++t) {
      taps.at[t] = std::clamp(static_cast<int>(low) + static_cast<int>(t) - 1, 0, source_size - 1);
      taps.weight[t] = static_cast<float>(weight[t]);
    }
  }
  return out;
}

/// [mm] A distance in the next slice as far as an outline that leans by 45 degrees can change it: a
/// part that ends there does not bend what goes on.
float leaning(float here, float next, float gap_mm) {
  return here + std::clamp(next - here, -gap_mm, gap_mm);
}

/// What the middle of a slice shows, from what the mean over its thickness does; see
/// without_voxel_mean. Slices at the end of the structure stay.
std::vector<Phase> without_slice_mean(const std::vector<Phase>& distances, float gap_mm) {
  std::vector<Phase> out = distances;
  for (std::size_t k = 1; k + 1 < distances.size(); ++k) {
    const Phase& before = distances[k - 1];
    const Phase& after = distances[k + 1];
    if (before.empty() || out[k].empty() || after.empty()) continue;
    for (std::size_t v = 0; v < out[k].size(); ++v) {
      const float here = distances[k][v];
      out[k][v] -=
          (leaning(here, before[v], gap_mm) - 2 * here + leaning(here, after[v], gap_mm)) / 24;
    }
  }
  return out;
}

Phase raw_from_coverage(const Grid& source, const Phase& coverage, const Grid& lattice,
                        const AxisMap& map) {
  const auto [nx, ny, nz] = lattice.size;
  const auto wide = static_cast<std::size_t>(nx);
  const std::vector<Taps> along_x = cubic_taps(map, 0, nx, source.size[0], true);
  const std::vector<Taps> along_y = cubic_taps(map, 1, ny, source.size[1], true);
  // Beyond the last slice the shape goes on, to be cut flat there.
  const std::vector<Taps> along_z = cubic_taps(map, 2, nz, source.size[2]);
  // One axis after the other; every source slice is brought into the lattice's plane once.
  std::vector<Phase> slices(static_cast<std::size_t>(source.size[2]));
  Phase rows(wide * static_cast<std::size_t>(source.size[1]));
  for (int k = 0; k < source.size[2]; ++k) {
    for (int j = 0; j < source.size[1]; ++j) {
      const float* from = coverage.data() + source.offset(0, j, k);
      float* to = rows.data() + static_cast<std::size_t>(j) * wide;
      for (const Taps& taps : along_x) {
        float sum = 0;
        for (std::size_t t = 0; t < 4; ++t) sum += taps.weight[t] * from[taps.at[t]];
        *to++ = sum;
      }
    }
    Phase& slice = slices[static_cast<std::size_t>(k)];
    slice.assign(lattice.slice_count(), 0.0F);
    for (std::size_t y = 0; y < along_y.size(); ++y) {
      for (std::size_t t = 0; t < 4; ++t) {
        const float weight = along_y[y].weight[t];
        const float* from = rows.data() + static_cast<std::size_t>(along_y[y].at[t]) * wide;
        float* to = slice.data() + y * wide;
        for (std::size_t x = 0; x < wide; ++x) to[x] += weight * from[x];
      }
    }
  }
  Phase level(lattice.count(), 0.5F);
  for (int z = 0; z < nz; ++z) {
    const Taps& taps = along_z[static_cast<std::size_t>(z)];
    float* to = level.data() + lattice.offset(0, 0, z);
    for (std::size_t t = 0; t < 4; ++t) {
      const float* from = slices[static_cast<std::size_t>(taps.at[t])].data();
      for (std::size_t n = 0; n < lattice.slice_count(); ++n) to[n] -= taps.weight[t] * from[n];
    }
  }
  return level;
}

/// Where the path runs between two slices.
Eigen::Vector2d between(const SectionPath& path, int one, int other, double share) {
  return (1 - share) * path[static_cast<std::size_t>(one)] +
         share * path[static_cast<std::size_t>(other)];
}

/// Between two slices, where the nearer outline would have to move by more than the gap between
/// them, a lean of 45 degrees, to become the other's: there a part of the section has no
/// counterpart in the other slice, as a ventricle that goes on beyond its valve as its outflow
/// tract alone. It ends flat half-way, as nothing tells where between them; gradually so from once
/// to twice the gap.
/// @param level that of an outline which moves  @param d0, d1 [mm] distances in both slices
/// @param w share of the way from the one to the other
float where_a_part_ends(float level, float d0, float d1, float w, float gap_mm) {
  const float ended = std::clamp(std::abs(d1 - d0) / gap_mm - 1, 0.0F, 1.0F);
  if (!(ended > 0)) return level;
  const float beyond_half = (w - 0.5F) * gap_mm;
  const float end = std::min(std::max(d0, beyond_half), std::max(d1, -beyond_half));
  return (1 - ended) * level + ended * end;
}

Phase raw_from_slices(const Grid& source, const std::vector<Phase>& means, const SectionPath& path,
                      const Grid& lattice, const AxisMap& map, int open_step,
                      const ApicalEnd& apex) {
  const auto gap_mm = static_cast<float>(source.spacing_mm()[2]);
  const std::vector<Phase> distances = without_slice_mean(means, gap_mm);
  Phase level(lattice.count(), kFar);
  const int nk = source.size[2];
  const auto has = [&](int k) {
    return k >= 0 && k < nk && !distances[static_cast<std::size_t>(k)].empty();
  };
  std::vector<float> depth(static_cast<std::size_t>(nk), 0);
  int tip = -1;  // the most apical slice
  for (int k = 0; k < nk; ++k) {
    if (!has(k)) continue;
    const Phase& d = distances[static_cast<std::size_t>(k)];
    depth[static_cast<std::size_t>(k)] = std::max(-*std::min_element(d.begin(), d.end()), 0.5F);
    if (apex.step > 0 || (apex.step < 0 && tip < 0)) tip = k;
  }
  const std::vector<Taps> across = cubic_taps(map, 2, lattice.size[2], nk);
  for (int z = 0; z < lattice.size[2]; ++z) {
    const double at = map.index(2, z);
    const bool past_tip = tip >= 0 && apex.step * (at - tip) > 0;
    const double k = std::clamp(at, 0.0, nk - 1.0);
    const int k0 = past_tip ? tip : static_cast<int>(std::floor(k));
    const int k1 = past_tip ? tip + apex.step : std::min(k0 + 1, nk - 1);
    if (!has(k0) && !has(k1)) continue;
    const auto w = static_cast<float>(past_tip ? std::abs(at - tip) : k - k0);
    // The way to an empty slice in which the shape is closed at a half.
    const float to_half = past_tip ? w * static_cast<float>(0.5 / apex.gaps) : 0;
    const bool cubic = !past_tip && has(k0 - 1) && has(k0) && has(k1) && has(k0 + 2);
    const std::array<float, 4>& weight = across[static_cast<std::size_t>(z)].weight;
    const Eigen::Vector2d here = past_tip ? path[static_cast<std::size_t>(tip)]
                                          : between(path, k0, k1, static_cast<double>(w));
    // On the open side the last slice is carried on unchanged; a cut ends it.
    const bool carry0 = has(k0) && !has(k1) && open_step > 0;
    const bool carry1 = has(k1) && !has(k0) && open_step < 0;
    for (int y = 0; y < lattice.size[1]; ++y) {
      const double j = map.index(1, y);
      for (int x = 0; x < lattice.size[0]; ++x) {
        const double i = map.index(0, x);
        const auto value = [&](int slice) {
          const auto n = static_cast<std::size_t>(slice);
          const Eigen::Vector2d aside = here - path[n];
          return sample_plane(distances[n].data(), source.size[0], source.size[1], i - aside[0],
                              j - aside[1]);
        };
        float& out = level[lattice.offset(x, y, z)];
        if (past_tip) {
          out = (1 - std::min(to_half, 1.0F)) * value(tip) +
                to_half * depth[static_cast<std::size_t>(tip)];
          continue;
        }
        float d0 = 0;
        float d1 = 0;
        if (has(k0)) d0 = value(k0);
        if (has(k1)) d1 = value(k1);
        if (cubic) {
          const float moved = weight[0] * leaning(d0, value(k0 - 1), gap_mm) + weight[1] * d0 +
                              weight[2] * d1 + weight[3] * leaning(d1, value(k0 + 2), gap_mm);
          out = where_a_part_ends(moved, d0, d1, w, gap_mm);
          continue;
        }
        const bool both = has(k0) && has(k1);
        if (!has(k0)) d0 = carry1 ? d1 : depth[static_cast<std::size_t>(k1)];
        if (!has(k1)) d1 = carry0 ? d0 : depth[static_cast<std::size_t>(k0)];
        out = (1 - w) * d0 + w * d1;
        if (both) out = where_a_part_ends(out, d0, d1, w, gap_mm);
      }
    }
  }
  return level;
}

}  // namespace

Phase level_from_coverage(const Grid& source, const Phase& coverage, const Grid& lattice,
                          const AxisMap& map, Creases creases) {
  const int parts = parts_of_slices(source);
  SubSlices thin = split_slices(source, coverage, parts);
  AxisMap thin_map = map;
  thin_map.scale[2] *= parts;
  thin_map.shift[2] = (map.shift[2] + 0.5) * parts - 0.5;
  Phase level = raw_from_coverage(thin.grid, thin.coverage, lattice, thin_map);
  thin.coverage = Phase();
  const Vec3 voxel = thin.grid.spacing_mm();
  if (creases == Creases::Keep) {
    smooth_between_creases(level, lattice, voxel);
  } else {
    smooth_evenly(level, lattice, Vec3::Constant(kSmoothMm * kSmoothMm) + voxel.cwiseAbs2() / 12);
  }
  return level;
}

Phase level_from_slices(const Grid& source, const std::vector<Phase>& distances,
                        const SectionPath& path, const Grid& lattice, const AxisMap& map,
                        int open_step, const ApicalEnd& apex) {
  Phase level = raw_from_slices(source, distances, path, lattice, map, open_step, apex);
  smooth_evenly(level, lattice, Vec3::Constant(kSmoothMm * kSmoothMm / 2));
  return level;
}

void open_toward_base(Phase& wall, const Grid& source, const std::vector<Phase>& outer,
                      const std::vector<Phase>& cavity, const SectionPath& path,
                      const Grid& lattice, const AxisMap& map, int open_step) {
  for (int z = 0; z < lattice.size[2]; ++z) {
    const double at = map.index(2, z);
    const int near = static_cast<int>(open_step > 0 ? std::floor(at) : std::ceil(at));
    const int next = near + open_step;
    if (std::min(near, next) < 0 || std::max(near, next) >= source.size[2]) continue;
    const Phase& within = cavity[static_cast<std::size_t>(near)];
    const Phase& beyond = outer[static_cast<std::size_t>(next)];
    if (within.empty() || beyond.empty()) continue;
    const Eigen::Vector2d here = between(path, near, next, std::abs(at - near));
    const Eigen::Vector2d from_near = here - path[static_cast<std::size_t>(near)];
    const Eigen::Vector2d from_next = here - path[static_cast<std::size_t>(next)];
    const auto sample = [&](const Phase& slice, double i, double j) {
      return sample_plane(slice.data(), source.size[0], source.size[1], i, j);
    };
    for (int y = 0; y < lattice.size[1]; ++y) {
      const double j = map.index(1, y);
      for (int x = 0; x < lattice.size[0]; ++x) {
        const double i = map.index(0, x);
        const float lid = std::min(-sample(within, i - from_near[0], j - from_near[1]),
                                   sample(beyond, i - from_next[0], j - from_next[1]));
        float& level = wall[lattice.offset(x, y, z)];
        level = std::max(level, lid);
      }
    }
  }
}

void cut_flat(Phase& level, const Grid& lattice, const AxisMap& map, double slice_mm, double at_k,
              int step) {
  for (int z = 0; z < lattice.size[2]; ++z) {
    const auto beyond_mm = static_cast<float>(step * (map.index(2, z) - at_k) * slice_mm);
    const auto from = level.begin() + static_cast<std::ptrdiff_t>(lattice.offset(0, 0, z));
    const auto to = from + static_cast<std::ptrdiff_t>(lattice.slice_count());
    std::transform(from, to, from, [&](float v) { return std::max(v, beyond_mm); });
  }
}

}  // namespace beatlas::reg
