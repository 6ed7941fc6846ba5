#pragma once
/// Boxes of voxels, and what images hold in one.

#include <cstdint>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas {

/// `first` included, `size` voxels.
struct Box {
  Index3 first{0, 0, 0};
  Index3 size{0, 0, 0};

  [[nodiscard]] bool empty() const { return size[2] == 0; }
  [[nodiscard]] bool contains(const Index3& at) const;
};

/// Whether a voxel of a mask is in it.
[[nodiscard]] inline bool is_set(std::uint8_t value) { return value != 0; }

/// Of a voxel, given as offset in the grid.
[[nodiscard]] Index3 index_of(const Grid& grid, std::size_t voxel);

/// The least box that holds what is not 0 in an image of the grid; empty if all is.
[[nodiscard]] Box box_around(const Grid& grid, const std::vector<std::uint8_t>& image);
/// The same for all images of a cycle.
[[nodiscard]] Box box_around(const Grid& grid,
                             const std::vector<std::vector<std::uint8_t>>& phases);
/// The same for voxels, as offsets in the grid.
[[nodiscard]] Box box_around_voxels(const Grid& grid, const std::vector<std::size_t>& voxels);

/// With `room` voxels more on each side, as far as the grid goes; an empty one stays empty.
[[nodiscard]] Box with_room(const Grid& grid, const Box& box, const Index3& room);

/// The box made to hold another, with a margin of 20 mm on the sides that the other
/// reaches or passes.
[[nodiscard]] Box widened(const Grid& grid, const Box& box, const Box& other);

/// The part of a cine, or of its labels, in a box. T: float, std::uint8_t.
template <class T>
[[nodiscard]] ImageCycle<T> crop(const ImageCycle<T>& images, const Box& box);

/// Labels of a box into those of the whole grid; beyond the box there are none.
void put_back(const ImageCycle<std::uint8_t>& labels, const Box& box,
              ImageCycle<std::uint8_t>& whole);

}  // namespace beatlas
