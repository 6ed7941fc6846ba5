#include "pipeline/core/box.h"

#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "runtime/atlas/structures.h"

namespace beatlas {
namespace {

/// The first and the last index of each axis.
struct Range {
  Index3 low;
  Index3 high{-1, -1, -1};

  explicit Range(const Grid& grid) : low(grid.size) {}

  void take(const Index3& at) {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], at[a]);
      high[a] = std::max(high[a], at[a]);
    }
  }
  void take(const Grid& grid, const std::vector<std::uint8_t>& image) {
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        const std::uint8_t* row = image.data() + grid.offset(0, j, k);
        const std::uint8_t* end = row + grid.size[0];
        const std::uint8_t* first = std::find_if(row, end, is_set);
        if (first == end) continue;
        const std::uint8_t* last = end - 1;
        while (!is_set(*last)) --last;
        take({static_cast<int>(first - row), j, k});
        take({static_cast<int>(last - row), j, k});
      }
    }
  }
  [[nodiscard]] Box box() const {
    if (high[2] < 0) return {};
    return {low, {high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1}};
  }
};

}  // namespace

Index3 index_of(const Grid& grid, std::size_t voxel) {
  const auto nx = static_cast<std::size_t>(grid.size[0]);
  const std::size_t in_slice = voxel % grid.slice_count();
  return {static_cast<int>(in_slice % nx), static_cast<int>(in_slice / nx),
          static_cast<int>(voxel / grid.slice_count())};
}

bool Box::contains(const Index3& at) const {
  for (std::size_t a = 0; a < 3; ++a) {
    if (at[a] < first[a] || at[a] >= first[a] + size[a]) return false;
  }
  return true;
}

Box box_around(const Grid& grid, const std::vector<std::uint8_t>& image) {
  Range range(grid);
  range.take(grid, image);
  return range.box();
}

Box box_around(const Grid& grid, const std::vector<std::vector<std::uint8_t>>& phases) {
  std::vector<Range> ranges(phases.size(), Range(grid));
  parallel_for(phases.size(), [&](std::size_t p) { ranges[p].take(grid, phases[p]); });
  Range all(grid);
  for (const Range& range : ranges) {
    if (range.high[2] < 0) continue;
    all.take(range.low);
    all.take(range.high);
  }
  return all.box();
}

Box box_around_voxels(const Grid& grid, const std::vector<std::size_t>& voxels) {
  Range range(grid);
  for (const std::size_t v : voxels) range.take(index_of(grid, v));
  return range.box();
}

Box with_room(const Grid& grid, const Box& box, const Index3& room) {
  if (box.empty()) return box;
  Box out;
  for (std::size_t a = 0; a < 3; ++a) {
    out.first[a] = std::max(0, box.first[a] - room[a]);
    out.size[a] = std::min(grid.size[a], box.first[a] + box.size[a] + room[a]) - out.first[a];
  }
  return out;
}

Box widened(const Grid& grid, const Box& box, const Box& other) {
  constexpr double kMarginMm = 20;
  if (other.empty()) return box;
  Box out;
  for (std::size_t a = 0; a < 3; ++a) {
    const int margin =
        static_cast<int>(std::ceil(kMarginMm / grid.spacing_mm()[static_cast<int>(a)]));
    int first = box.first[a];
    int last = first + box.size[a] - 1;
    const int other_last = other.first[a] + other.size[a] - 1;
    if (other.first[a] <= first) first = std::max(0, other.first[a] - margin);
    if (other_last >= last) last = std::min(grid.size[a] - 1, other_last + margin);
    out.first[a] = first;
    out.size[a] = last - first + 1;
  }
  return out;
}

template <class T>
ImageCycle<T> crop(const ImageCycle<T>& images, const Box& box) {
  ImageCycle<T> out;
  out.grid = images.grid.part(box.first, box.size);
  out.phases.resize(images.phases.size());
  parallel_for(images.phases.size(), [&](std::size_t p) {
    out.phases[p].reserve(out.grid.count());
    for (int k = 0; k < box.size[2]; ++k) {
      for (int j = 0; j < box.size[1]; ++j) {
        const auto from =
            images.phases[p].begin() + static_cast<std::ptrdiff_t>(images.grid.offset(
                                           box.first[0], box.first[1] + j, box.first[2] + k));
        out.phases[p].insert(out.phases[p].end(), from, from + box.size[0]);
      }
    }
  });
  return out;
}

template ImageCycle<float> crop(const ImageCycle<float>&, const Box&);
template ImageCycle<std::uint8_t> crop(const ImageCycle<std::uint8_t>&, const Box&);

void put_back(const ImageCycle<std::uint8_t>& labels, const Box& box,
              ImageCycle<std::uint8_t>& whole) {
  whole.phases.resize(labels.phases.size());
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    whole.phases[p].assign(whole.grid.count(), kLabelBackground);
    for (int k = 0; k < box.size[2]; ++k) {
      for (int j = 0; j < box.size[1]; ++j) {
        const auto from =
            labels.phases[p].begin() + static_cast<std::ptrdiff_t>(labels.grid.offset(0, j, k));
        std::copy(from, from + box.size[0],
                  whole.phases[p].begin() + static_cast<std::ptrdiff_t>(whole.grid.offset(
                                                box.first[0], box.first[1] + j, box.first[2] + k)));
      }
    }
  });
}

}  // namespace beatlas
