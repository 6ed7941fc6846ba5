#include "pipeline/shape/shape_level.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/core/cubic_convolution.h"
#include "pipeline/shape/smooth_level.h"
#include "pipeline/shape/sub_slices.h"

namespace beatlas::shape {

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

/// A structure's slices as they are read between: in-plane distances [mm] of those that hold it.
class Sections {
 public:
  /// All must outlive this.
  Sections(const Grid& source, const std::vector<Phase>& distances, const SectionPath& path)
      : source_(source), distances_(distances), path_(path), depth_mm_(distances.size(), 0) {
    for (std::size_t k = 0; k < distances.size(); ++k) {
      const Phase& d = distances[k];
      if (!d.empty()) depth_mm_[k] = std::max(-*std::min_element(d.begin(), d.end()), 0.5F);
    }
  }

  [[nodiscard]] int count() const { return source_.size[2]; }
  [[nodiscard]] bool has(int k) const {
    return k >= 0 && k < count() && !distances_[static_cast<std::size_t>(k)].empty();
  }
  [[nodiscard]] const SectionPath& path() const { return path_; }
  /// [mm] How far the section's middle lies from its outline.
  [[nodiscard]] float depth_mm(int k) const { return depth_mm_[static_cast<std::size_t>(k)]; }

  /// The most apical slice that holds the structure; -1: there is none, or no step.
  [[nodiscard]] int tip(int step_to_apex) const {
    int out = -1;
    for (int k = 0; k < count(); ++k) {
      if (has(k) && (step_to_apex > 0 || (step_to_apex < 0 && out < 0))) out = k;
    }
    return out;
  }

  /// [mm] What a slice tells of index (i, j) of a plane through which the path runs at `here`.
  [[nodiscard]] float distance_mm(int k, const Eigen::Vector2d& here, double i, double j) const {
    const auto n = static_cast<std::size_t>(k);
    const Eigen::Vector2d aside = here - path_[n];
    return sample_plane(distances_[n].data(), source_.size[0], source_.size[1], i - aside[0],
                        j - aside[1]);
  }

 private:
  const Grid& source_;
  const std::vector<Phase>& distances_;
  const SectionPath& path_;
  std::vector<float> depth_mm_;
};

/// One plane of a level.
struct LevelPlane {
  const Grid& lattice;
  const AxisMap& map;
  int z = 0;
  Phase& level;

  /// Sets it to value(i, j) of the source's indices.
  template <class Value>
  void fill(const Value& value) const {
    for (int y = 0; y < lattice.size[1]; ++y) {
      const double j = map.index(1, y);
      for (int x = 0; x < lattice.size[0]; ++x) {
        level[lattice.offset(x, y, z)] = value(map.index(0, x), j);
      }
    }
  }
};

/// Beyond the most apical slice the shape closes roundly.
/// @param gaps from that slice to the plane
void close_beyond_tip(const Sections& sections, int tip, float gaps, const ApicalEnd& apex,
                      const LevelPlane& plane) {
  // The way to an empty slice in which the shape is closed at a half.
  const float to_half = gaps * static_cast<float>(0.5 / apex.gaps);
  const Eigen::Vector2d here = sections.path()[static_cast<std::size_t>(tip)];
  plane.fill([&](double i, double j) {
    return (1 - std::min(to_half, 1.0F)) * sections.distance_mm(tip, here, i, j) +
           to_half * sections.depth_mm(tip);
  });
}

/// Between two slices at `k`, of which at least one holds the structure.
/// @param weight cubic, of four slices  @param open_step of the structure's ValvePlane
void blend_slices(const Sections& sections, double k, const std::array<float, 4>& weight,
                  int open_step, float gap_mm, const LevelPlane& plane) {
  const int k0 = static_cast<int>(std::floor(k));
  const int k1 = std::min(k0 + 1, sections.count() - 1);
  const bool has0 = sections.has(k0);
  const bool has1 = sections.has(k1);
  if (!has0 && !has1) return;
  const auto w = static_cast<float>(k - k0);
  const Eigen::Vector2d here = between(sections.path(), k0, k1, static_cast<double>(w));
  if (!has0 || !has1) {
    const int held = has0 ? k0 : k1;
    // On the open side the last slice is carried on unchanged; a cut ends it.
    const bool carried = has0 ? open_step > 0 : open_step < 0;
    plane.fill([&](double i, double j) {
      const float d = sections.distance_mm(held, here, i, j);
      const float beside = carried ? d : sections.depth_mm(held);
      return has0 ? (1 - w) * d + w * beside : (1 - w) * beside + w * d;
    });
    return;
  }
  if (sections.has(k0 - 1) && sections.has(k0 + 2)) {
    plane.fill([&](double i, double j) {
      const auto d = [&](int slice) { return sections.distance_mm(slice, here, i, j); };
      const float d0 = d(k0);
      const float d1 = d(k1);
      const float moved = weight[0] * leaning(d0, d(k0 - 1), gap_mm) + weight[1] * d0 +
                          weight[2] * d1 + weight[3] * leaning(d1, d(k0 + 2), gap_mm);
      return where_a_part_ends(moved, d0, d1, w, gap_mm);
    });
    return;
  }
  plane.fill([&](double i, double j) {
    const float d0 = sections.distance_mm(k0, here, i, j);
    const float d1 = sections.distance_mm(k1, here, i, j);
    return where_a_part_ends((1 - w) * d0 + w * d1, d0, d1, w, gap_mm);
  });
}

Phase raw_from_slices(const Grid& source, const std::vector<Phase>& means, const SectionPath& path,
                      const Grid& lattice, const AxisMap& map, int open_step,
                      const ApicalEnd& apex) {
  const auto gap_mm = static_cast<float>(source.spacing_mm()[2]);
  const std::vector<Phase> distances = without_slice_mean(means, gap_mm);
  const Sections sections(source, distances, path);
  const int tip = sections.tip(apex.step);
  const int nk = source.size[2];
  const std::vector<Taps> across = cubic_taps(map, 2, lattice.size[2], nk);
  Phase level(lattice.count(), kFar);
  for (int z = 0; z < lattice.size[2]; ++z) {
    const double at = map.index(2, z);
    const LevelPlane plane{lattice, map, z, level};
    if (tip >= 0 && apex.step * (at - tip) > 0) {
      close_beyond_tip(sections, tip, static_cast<float>(std::abs(at - tip)), apex, plane);
      continue;
    }
    blend_slices(sections, std::clamp(at, 0.0, nk - 1.0),
                 across[static_cast<std::size_t>(z)].weight, open_step, gap_mm, plane);
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

void cut_beside(Phase& level, const Grid& lattice, const AxisMap& map, const Grid& source) {
  const Vec3 spacing = source.spacing_mm();
  std::array<std::vector<float>, 2> beyond_mm;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    for (int n = 0; n < lattice.size[axis]; ++n) {
      const double index = map.index(static_cast<int>(axis), n);
      const double beyond = std::max(-0.5 - index, index - (source.size[axis] - 0.5));
      beyond_mm[axis].push_back(
          static_cast<float>(beyond * spacing[static_cast<Eigen::Index>(axis)]));
    }
  }
  for_each_voxel(lattice, [&](int x, int y, int, std::size_t v) {
    const float beyond = std::max(beyond_mm[0][static_cast<std::size_t>(x)],
                                  beyond_mm[1][static_cast<std::size_t>(y)]);
    if (beyond > 0) level[v] = std::max(level[v], beyond);
  });
}

}  // namespace beatlas::shape
