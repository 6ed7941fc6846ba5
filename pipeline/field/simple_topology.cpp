#include "pipeline/field/simple_topology.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <queue>
#include <utility>

#include "pipeline/field/simple_points.h"

namespace beatlas::field {
namespace {

/// Which corners of the cube above a sample are inside; bits 0, 1 and 2 of a corner's number are
/// its steps along i, j and k.
std::array<bool, 8> cube_above(const Grid& grid, const Mask& inside, int i, int j, int k) {
  std::array<bool, 8> corner{};
  for (int c = 0; c < 8; ++c) {
    const int x = i + (c & 1);
    const int y = j + (c >> 1 & 1);
    const int z = k + (c >> 2 & 1);
    corner[static_cast<std::size_t>(c)] =
        grid.contains(x, y, z) && inside[grid.offset(x, y, z)] != 0;
  }
  return corner;
}

/// V - E + F - T of the simplices that are wholly inside and whose lowest corner is that of a cube,
/// which is inside: up to 1, 7, 12 and 6, along chains of the cube's corners.
int euler_number_of(const std::array<bool, 8>& corner) {
  if (std::count(corner.begin(), corner.end(), true) == 8) return 0;  // 1 - 7 + 12 - 6
  int out = 1;
  for (unsigned a = 1; a < 8; ++a) {
    if (!corner[a]) continue;
    --out;
    for (unsigned b = a + 1; b < 8; ++b) {
      if ((a & b) != a || !corner[b]) continue;
      ++out;
      for (unsigned c = b + 1; c < 8; ++c) {
        if ((b & c) == b && corner[c]) --out;
      }
    }
  }
  return out;
}

/// V - E + F - T of all simplices that are wholly inside.
int euler_number(const Grid& grid, const Mask& inside) {
  int out = 0;
  for_each_voxel(grid, [&](int i, int j, int k, std::size_t v) {
    if (inside[v] != 0) out += euler_number_of(cube_above(grid, inside, i, j, k));
  });
  return out;
}

/// Lets one side grow by simple points from where it is surest to where it is least so; what it
/// could not reach.
/// @param side 1: the inside, from its deepest sample; 0: the outside, from beyond the lattice
std::vector<std::size_t> not_reached(const Lattice& lattice, const Mask& inside,
                                     const std::vector<float>& samples, std::uint8_t side) {
  const float sign = side == 1 ? 1.0F : -1.0F;
  std::priority_queue<Waiting<float>> queue;
  Mask waits(inside.size());
  Mask grown(inside.size());
  std::uint64_t turn = 0;
  const auto push = [&](std::size_t index) {
    if (grown[index] != 0 || waits[index] != 0 || inside[index] != side) return;
    waits[index] = 1;
    // Where a change was forced the sample's sign may differ from its side.
    queue.push({std::min(sign * samples[index], 0.0F), turn++, index});
  };
  const auto add = [&](std::size_t index) {
    grown[index] = 1;
    lattice.around(index, [&](std::size_t, std::size_t to) { push(to); });
  };
  std::size_t wanted = 0;
  std::size_t deepest = inside.size();
  for (std::size_t n = 0; n < inside.size(); ++n) {
    if (inside[n] != side) continue;
    ++wanted;
    if (side == 0) {
      if (lattice.on_border(lattice.at(n))) push(n);
    } else if (deepest == inside.size() || samples[n] < samples[deepest]) {
      deepest = n;
    }
  }
  std::size_t reached = 0;
  if (side == 1 && deepest < inside.size()) {
    add(deepest);
    ++reached;
  }
  while (!queue.empty()) {
    const std::size_t index = queue.top().index;
    queue.pop();
    waits[index] = 0;
    if (!lattice.is_simple(grown, index, side == 0)) continue;  // beyond the lattice is outside
    add(index);
    ++reached;
  }
  std::vector<std::size_t> out;
  if (reached == wanted) return out;
  for (std::size_t n = 0; n < inside.size(); ++n) {
    if (inside[n] == side && grown[n] == 0) out.push_back(n);
  }
  return out;
}

/// Samples that change side together.
struct Change {
  std::vector<std::size_t> samples;
  double cost = 0;
};

void cluster(const Grid& grid, const Lattice& lattice, const std::vector<float>& samples,
             const std::vector<std::size_t>& all, std::vector<Change>& out) {
  Mask member(samples.size());
  for (const std::size_t n : all) member[n] = 1;
  for (const std::size_t start : all) {
    if (member[start] != 1) continue;
    Change change;
    change.samples.push_back(start);
    member[start] = 2;
    for (std::size_t n = 0; n < change.samples.size(); ++n) {
      change.cost += std::abs(static_cast<double>(samples[change.samples[n]]));
      const Index3 here = lattice.at(change.samples[n]);
      for (int step = 0; step < 27; ++step) {
        const int i = here[0] + step % 3 - 1;
        const int j = here[1] + step / 3 % 3 - 1;
        const int k = here[2] + step / 9 - 1;
        if (!grid.contains(i, j, k) || member[grid.offset(i, j, k)] != 1) continue;
        member[grid.offset(i, j, k)] = 2;
        change.samples.push_back(grid.offset(i, j, k));
      }
    }
    out.push_back(std::move(change));
  }
}

BodyTopology topology_of(const Grid& grid, const Lattice& lattice, const Mask& inside) {
  BodyTopology out;
  out.pieces = static_cast<int>(pieces_of(lattice, inside, 1).size());
  for (const Piece& piece : pieces_of(lattice, inside, 0)) out.hollows += piece.at_border ? 0 : 1;
  out.handles = out.pieces + out.hollows - euler_number(grid, inside);
  return out;
}

}  // namespace

BodyTopology topology_of(const Grid& grid, const std::vector<float>& samples) {
  return topology_of(grid, Lattice(grid), inside_of(samples));
}

Repair make_ball(const Grid& grid, std::vector<float>& samples) {
  const Lattice lattice(grid);
  Mask inside = inside_of(samples);
  Repair out;
  out.before = topology_of(grid, lattice, inside);
  if (out.before.is_ball() || out.before.pieces == 0) return out;

  make_one_body(grid, samples, inside);
  BodyTopology now = topology_of(grid, lattice, inside);
  while (now.handles > 0) {
    std::vector<Change> changes;
    for (const std::uint8_t side : {std::uint8_t{1}, std::uint8_t{0}}) {
      cluster(grid, lattice, samples, not_reached(lattice, inside, samples, side), changes);
    }
    std::stable_sort(changes.begin(), changes.end(),
                     [](const Change& a, const Change& b) { return a.cost < b.cost; });
    bool better = false;
    for (const Change& change : changes) {
      flip(inside, change.samples);
      const BodyTopology then = topology_of(grid, lattice, inside);
      if (then.pieces == 1 && then.hollows == 0 && then.handles < now.handles) {
        now = then;
        better = true;
        break;
      }
      flip(inside, change.samples);
    }
    if (!better) break;
  }
  if (now.handles > 0) {
    // Several changes that hang together: all that the cheaper side could not reach.
    std::vector<std::size_t> cut = not_reached(lattice, inside, samples, 1);
    std::vector<std::size_t> filled = not_reached(lattice, inside, samples, 0);
    const auto cost = [&](const std::vector<std::size_t>& all) {
      double sum = 0;
      for (const std::size_t n : all) sum += std::abs(static_cast<double>(samples[n]));
      return sum;
    };
    flip(inside, cost(cut) < cost(filled) ? cut : filled);
    now = topology_of(grid, lattice, inside);
  }
  out.left_handles = now.handles;
  out.changed = change_sides(grid, inside, samples);
  return out;
}

}  // namespace beatlas::field
