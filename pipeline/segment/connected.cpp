#include "pipeline/segment/connected.h"

#include <algorithm>
#include <vector>

#include "pipeline/core/parallel.h"
#include "runtime/atlas/structures.h"

namespace beatlas::segment {
namespace {

/// Parts of what `holds` over some phases, one after the other, that share faces of voxels or, with
/// more than one, places in phases that follow each other round the cycle.
/// @return [phase * voxels + voxel] 1 in the largest part, 2 in others, 0 where nothing is held
template <class Holds>
std::vector<std::uint8_t> largest_part(const Grid& grid, std::size_t phases, const Holds& holds) {
  const std::size_t count = grid.count();
  const auto nx = static_cast<std::size_t>(grid.size[0]);
  const std::size_t slice = grid.slice_count();
  std::vector<std::uint32_t> part(count * phases, 0);
  std::vector<std::uint32_t> stack;
  std::uint32_t parts = 0;
  std::uint32_t largest = 0;
  std::size_t largest_size = 0;
  for (std::size_t start = 0; start < count * phases; ++start) {
    if (part[start] != 0 || !holds(start / count, start % count)) continue;
    ++parts;
    std::size_t size = 0;
    stack.assign(1, static_cast<std::uint32_t>(start));
    part[start] = parts;
    while (!stack.empty()) {
      const std::size_t node = stack.back();
      stack.pop_back();
      ++size;
      const std::size_t p = node / count;
      const std::size_t v = node % count;
      const auto visit = [&](std::size_t to_phase, std::size_t to) {
        const std::size_t index = to_phase * count + to;
        if (part[index] != 0 || !holds(to_phase, to)) return;
        part[index] = parts;
        stack.push_back(static_cast<std::uint32_t>(index));
      };
      if (v % nx > 0) visit(p, v - 1);
      if (v % nx + 1 < nx) visit(p, v + 1);
      if (v % slice >= nx) visit(p, v - nx);
      if (v % slice + nx < slice) visit(p, v + nx);
      if (v >= slice) visit(p, v - slice);
      if (v + slice < count) visit(p, v + slice);
      visit((p + 1) % phases, v);
      visit((p + phases - 1) % phases, v);
    }
    if (size > largest_size) {
      largest_size = size;
      largest = parts;
    }
  }
  std::vector<std::uint8_t> out(part.size());
  std::transform(part.begin(), part.end(), out.begin(), [&](std::uint32_t id) {
    return static_cast<std::uint8_t>(id == 0 ? 0 : id == largest ? 1 : 2);
  });
  return out;
}

}  // namespace

void keep_connected_heart(ImageCycle<std::uint8_t>& labels) {
  const std::size_t count = labels.grid.count();
  const std::vector<std::uint8_t> part =
      largest_part(labels.grid, labels.phases.size(),
                   [&](std::size_t p, std::size_t v) { return labels.phases[p][v] != 0; });
  for (std::size_t node = 0; node < part.size(); ++node) {
    if (part[node] == 2) labels.phases[node / count][node % count] = kLabelBackground;
  }
}

std::vector<std::uint32_t> keep_connected_rv(const Grid& grid, std::vector<std::uint8_t>& labels) {
  std::vector<std::uint32_t> apart;
  const std::vector<std::uint8_t> part =
      largest_part(grid, 1, [&](std::size_t, std::size_t v) { return labels[v] == kLabelRvBlood; });
  for (std::size_t v = 0; v < part.size(); ++v) {
    if (part[v] != 2) continue;
    labels[v] = kLabelRestOfHeart;
    apart.push_back(static_cast<std::uint32_t>(v));
  }
  return apart;
}

VoxelCycle keep_connected_rv(ImageCycle<std::uint8_t>& labels) {
  VoxelCycle apart(labels.phases.size());
  parallel_for(labels.phases.size(),
               [&](std::size_t p) { apart[p] = keep_connected_rv(labels.grid, labels.phases[p]); });
  return apart;
}

VoxelCycle relabel(const VoxelCycle& voxels, std::uint8_t from, std::uint8_t to,
                   ImageCycle<std::uint8_t>& labels) {
  VoxelCycle changed(voxels.size());
  for (std::size_t p = 0; p < voxels.size(); ++p) {
    for (const std::uint32_t v : voxels[p]) {
      if (labels.phases[p][v] != from) continue;
      labels.phases[p][v] = to;
      changed[p].push_back(v);
    }
  }
  return changed;
}

}  // namespace beatlas::segment
