#include "pipeline/mesh/simple_topology.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <queue>
#include <utility>

namespace beatlas::mesh {
namespace {

constexpr std::size_t kNeighbours = 14;
constexpr std::uint32_t kAll = (1U << kNeighbours) - 1;

/// The steps to a sample's neighbours: to the other corners of a cube that lie along a monotone
/// path, and back.
constexpr std::array<Index3, kNeighbours> make_steps() {
  std::array<Index3, kNeighbours> out{};
  for (int bits = 1; bits < 8; ++bits) {
    const Index3 ahead{bits & 1, bits >> 1 & 1, bits >> 2 & 1};
    out[static_cast<std::size_t>(bits - 1)] = ahead;
    out[static_cast<std::size_t>(bits + 6)] = {-ahead[0], -ahead[1], -ahead[2]};
  }
  return out;
}
constexpr std::array<Index3, kNeighbours> kSteps = make_steps();

/// Which neighbours are neighbours of each other: the edges of the sphere around a sample.
constexpr std::array<std::uint32_t, kNeighbours> make_links() {
  std::array<std::uint32_t, kNeighbours> out{};
  for (std::size_t a = 0; a < kNeighbours; ++a) {
    for (std::size_t b = 0; b < kNeighbours; ++b) {
      for (const Index3& step : kSteps) {
        if (kSteps[a][0] + step[0] == kSteps[b][0] && kSteps[a][1] + step[1] == kSteps[b][1] &&
            kSteps[a][2] + step[2] == kSteps[b][2]) {
          out[a] |= 1U << b;
        }
      }
    }
  }
  return out;
}
constexpr std::array<std::uint32_t, kNeighbours> kLinks = make_links();

bool is_one_piece(std::uint32_t members) {
  if (members == 0) return false;
  std::uint32_t reached = members & (~members + 1);
  for (std::uint32_t fresh = reached; fresh != 0;) {
    std::uint32_t next = 0;
    for (; fresh != 0; fresh &= fresh - 1) {
      next |= kLinks[static_cast<std::size_t>(std::countr_zero(fresh))];
    }
    fresh = next & members & ~reached;
    reached |= fresh;
  }
  return reached == members;
}

class Lattice {
 public:
  explicit Lattice(const Grid& grid) : size_(grid.size) {
    for (std::size_t n = 0; n < kNeighbours; ++n) {
      offset_[n] = static_cast<std::ptrdiff_t>(kSteps[n][0]) +
                   size_[0] * (kSteps[n][1] + static_cast<std::ptrdiff_t>(size_[1]) * kSteps[n][2]);
    }
  }
  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) *
           static_cast<std::size_t>(size_[2]);
  }
  [[nodiscard]] Index3 at(std::size_t index) const {
    const auto nx = static_cast<std::size_t>(size_[0]);
    const auto ny = static_cast<std::size_t>(size_[1]);
    return {static_cast<int>(index % nx), static_cast<int>(index / nx % ny),
            static_cast<int>(index / nx / ny)};
  }
  [[nodiscard]] bool on_border(const Index3& at) const {
    for (std::size_t n = 0; n < 3; ++n) {
      if (at[n] == 0 || at[n] == size_[n] - 1) return true;
    }
    return false;
  }
  /// Calls visit(neighbour's number, index) for those within the lattice.
  template <class Visit>
  void around(std::size_t index, const Visit& visit) const {
    const Index3 here = at(index);
    const bool inner = !on_border(here);
    for (std::size_t n = 0; n < kNeighbours; ++n) {
      if (!inner) {
        bool within = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const int to = here[axis] + kSteps[n][axis];
          within = within && to >= 0 && to < size_[axis];
        }
        if (!within) continue;
      }
      visit(n, static_cast<std::size_t>(static_cast<std::ptrdiff_t>(index) + offset_[n]));
    }
  }

 private:
  Index3 size_;
  std::array<std::ptrdiff_t, kNeighbours> offset_{};
};

using Mask = std::vector<std::uint8_t>;

Mask inside_of(const std::vector<float>& samples) {
  Mask out(samples.size());
  for (std::size_t n = 0; n < samples.size(); ++n) out[n] = samples[n] < 0 ? 1 : 0;
  return out;
}

/// A piece of the samples of one side.
struct Piece {
  std::vector<std::size_t> samples;
  bool at_border = false;
};

std::vector<Piece> pieces_of(const Lattice& lattice, const Mask& inside, std::uint8_t side) {
  Mask seen(inside.size());
  std::vector<Piece> out;
  for (std::size_t start = 0; start < inside.size(); ++start) {
    if (seen[start] != 0 || inside[start] != side) continue;
    Piece piece;
    piece.samples.push_back(start);
    seen[start] = 1;
    for (std::size_t n = 0; n < piece.samples.size(); ++n) {
      const std::size_t here = piece.samples[n];
      piece.at_border = piece.at_border || lattice.on_border(lattice.at(here));
      lattice.around(here, [&](std::size_t, std::size_t to) {
        if (seen[to] != 0 || inside[to] != side) return;
        seen[to] = 1;
        piece.samples.push_back(to);
      });
    }
    out.push_back(std::move(piece));
  }
  return out;
}

/// V - E + F - T of the simplices that are wholly inside. Those whose lowest corner is a sample:
/// 1, 7, 12 and 6, along chains of corners of the cube above it.
int euler_number(const Grid& grid, const Mask& inside) {
  int out = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (inside[grid.offset(i, j, k)] == 0) continue;
        std::array<bool, 8> corner{};
        int full = 0;
        for (int c = 0; c < 8; ++c) {
          const int x = i + (c & 1);
          const int y = j + (c >> 1 & 1);
          const int z = k + (c >> 2 & 1);
          corner[static_cast<std::size_t>(c)] =
              grid.contains(x, y, z) && inside[grid.offset(x, y, z)] != 0;
          full += corner[static_cast<std::size_t>(c)] ? 1 : 0;
        }
        if (full == 8) continue;  // 1 - 7 + 12 - 6
        int own = 1;
        for (unsigned a = 1; a < 8; ++a) {
          if (!corner[a]) continue;
          --own;
          for (unsigned b = a + 1; b < 8; ++b) {
            if ((a & b) != a || !corner[b]) continue;
            ++own;
            for (unsigned c = b + 1; c < 8; ++c) {
              if ((b & c) == b && corner[c]) --own;
            }
          }
        }
        out += own;
      }
    }
  }
  return out;
}

/// Lets one side grow by simple points from where it is surest to where it is least so; what it
/// could not reach.
/// @param side 1: the inside, from its deepest sample; 0: the outside, from beyond the lattice
std::vector<std::size_t> not_reached(const Lattice& lattice, const Mask& inside,
                                     const std::vector<float>& samples, std::uint8_t side) {
  struct Next {
    float level;
    std::uint64_t turn;
    std::size_t index;
    bool operator<(const Next& other) const {
      return level != other.level ? level > other.level : turn > other.turn;
    }
  };
  const float sign = side == 1 ? 1.0F : -1.0F;
  std::priority_queue<Next> queue;
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
    std::uint32_t own = side == 0 ? kAll : 0;  // beyond the lattice is outside
    lattice.around(index, [&](std::size_t n, std::size_t to) {
      if ((grown[to] != 0) != (((own >> n) & 1U) != 0)) own ^= 1U << n;
    });
    if (!is_one_piece(own) || !is_one_piece(kAll & ~own)) continue;
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

void flip(Mask& inside, const std::vector<std::size_t>& samples) {
  for (const std::size_t n : samples) inside[n] ^= 1U;
}

/// Gives samples the side they are to have and eases those around.
void apply(const Grid& grid, const Lattice& lattice, const Mask& inside,
           std::vector<float>& samples) {
  constexpr double kHalfWidth = 0.3;  // of a sample
  constexpr int kReach = 2;
  const double voxel_mm = grid.spacing_mm().x();
  std::vector<float> out = samples;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if ((samples[n] < 0) == (inside[n] != 0)) continue;
    const double sign = inside[n] != 0 ? -1.0 : 1.0;
    const Index3 here = lattice.at(n);
    for (int dk = -kReach; dk <= kReach; ++dk) {
      for (int dj = -kReach; dj <= kReach; ++dj) {
        for (int di = -kReach; di <= kReach; ++di) {
          if (!grid.contains(here[0] + di, here[1] + dj, here[2] + dk)) continue;
          const std::size_t to = grid.offset(here[0] + di, here[1] + dj, here[2] + dk);
          const auto eased = static_cast<float>(
              sign * voxel_mm * (kHalfWidth - std::sqrt(di * di + dj * dj + dk * dk)));
          out[to] = sign > 0 ? std::max(out[to], eased) : std::min(out[to], eased);
        }
      }
    }
  }
  // Where a cut and a filling are neighbours each has what it was made for.
  for (std::size_t n = 0; n < out.size(); ++n) {
    const auto least = static_cast<float>(kHalfWidth * voxel_mm);
    if (inside[n] != 0 && !(out[n] < 0)) out[n] = -least;
    if (inside[n] == 0 && out[n] < 0) out[n] = least;
  }
  samples = std::move(out);
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

  std::vector<Piece> pieces = pieces_of(lattice, inside, 1);
  const auto largest = std::max_element(
      pieces.begin(), pieces.end(),
      [](const Piece& a, const Piece& b) { return a.samples.size() < b.samples.size(); });
  for (auto piece = pieces.begin(); piece != pieces.end(); ++piece) {
    if (piece != largest) flip(inside, piece->samples);
  }
  for (const Piece& piece : pieces_of(lattice, inside, 0)) {
    if (!piece.at_border) flip(inside, piece.samples);
  }

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
  for (std::size_t n = 0; n < samples.size(); ++n) {
    out.changed += (samples[n] < 0) != (inside[n] != 0) ? 1 : 0;
  }
  apply(grid, lattice, inside, samples);
  return out;
}

}  // namespace beatlas::mesh
