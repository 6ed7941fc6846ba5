#pragma once
#include <cmath>
#include <cstddef>
#include <vector>

#include "runtime/base/geometry.h"

namespace beatlas {

/// A regular lattice of voxels, i fastest. Voxel centres are at integer indices.
struct Grid {
  Index3 size{0, 0, 0};
  /// Index (i, j, k) -> patient LPS [mm], or workspace [mm] where the owner says so.
  Affine mm_from_index = Affine::Identity();

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  [[nodiscard]] std::size_t slice_count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
  }
  [[nodiscard]] std::size_t offset(int i, int j, int k) const {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(size[0]) *
               (static_cast<std::size_t>(j) +
                static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(k));
  }
  [[nodiscard]] bool contains(int i, int j, int k) const {
    return i >= 0 && j >= 0 && k >= 0 && i < size[0] && j < size[1] && k < size[2];
  }
  /// Edge lengths of a voxel [mm] along i, j, k.
  [[nodiscard]] Vec3 spacing_mm() const {
    return mm_from_index.linear().colwise().norm().transpose();
  }
  [[nodiscard]] double voxel_ml() const {
    return std::abs(mm_from_index.linear().determinant()) * 1e-3;
  }
  [[nodiscard]] Vec3 mm(double i, double j, double k) const {
    return mm_from_index * Vec3(i, j, k);
  }

  /// The part of this grid that starts at voxel `first` and has `part_size` voxels.
  [[nodiscard]] Grid part(const Index3& first, const Index3& part_size) const {
    Grid out{part_size, mm_from_index};
    out.mm_from_index.translation() = mm(first[0], first[1], first[2]);
    return out;
  }
  [[nodiscard]] bool operator==(const Grid& other) const {
    return size == other.size && mm_from_index.matrix() == other.mm_from_index.matrix();
  }
};

/// Calls visit(i, j, k, v) for every voxel in the order of their offsets v.
template <class Visit>
void for_each_voxel(const Grid& grid, const Visit& visit) {
  std::size_t v = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++v) visit(i, j, k, v);
    }
  }
}

/// One scalar image; `voxels.size() == grid.count()`.
template <class T>
struct Volume {
  Grid grid;
  std::vector<T> voxels;

  [[nodiscard]] T& at(int i, int j, int k) { return voxels[grid.offset(i, j, k)]; }
  [[nodiscard]] const T& at(int i, int j, int k) const { return voxels[grid.offset(i, j, k)]; }
};

/// One image a phase on a common grid: `phases[p].size() == grid.count()`.
template <class T>
struct ImageCycle {
  Grid grid;
  std::vector<std::vector<T>> phases;

  [[nodiscard]] int phase_count() const { return static_cast<int>(phases.size()); }
};

}  // namespace beatlas
