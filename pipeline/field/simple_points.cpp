#include "pipeline/field/simple_points.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <queue>

namespace beatlas::field {
namespace {

constexpr std::uint32_t kAll = (1U << kNeighbours) - 1;

/// Which neighbours are neighbours of each other: the edges of the sphere around a sample.
constexpr std::array<std::uint32_t, kNeighbours> make_links() {
  std::array<std::uint32_t, kNeighbours> out{};
  for (std::size_t a = 0; a < kNeighbours; ++a) {
    for (std::size_t b = 0; b < kNeighbours; ++b) {
      for (const Index3& step : kNeighbourSteps) {
        if (kNeighbourSteps[a][0] + step[0] == kNeighbourSteps[b][0] &&
            kNeighbourSteps[a][1] + step[1] == kNeighbourSteps[b][1] &&
            kNeighbourSteps[a][2] + step[2] == kNeighbourSteps[b][2]) {
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

}  // namespace

Mask inside_of(const std::vector<float>& samples) {
  Mask out(samples.size());
  for (std::size_t n = 0; n < samples.size(); ++n) out[n] = samples[n] < 0 ? 1 : 0;
  return out;
}

void flip(Mask& inside, const std::vector<std::size_t>& samples) {
  for (const std::size_t n : samples) inside[n] ^= 1U;
}

bool Lattice::is_simple(const Mask& set, std::size_t index, bool beyond) const {
  std::uint32_t own = beyond ? kAll : 0;
  around(index, [&](std::size_t n, std::size_t to) {
    if ((set[to] != 0) != (((own >> n) & 1U) != 0)) own ^= 1U << n;
  });
  return is_one_piece(own) && is_one_piece(kAll & ~own);
}

bool Lattice::is_thread(const Mask& set, std::size_t index) const {
  std::uint32_t own = 0;
  around(index, [&](std::size_t n, std::size_t to) {
    if (set[to] != 0) own |= 1U << n;
  });
  return set[index] != 0 && own != 0 && !is_one_piece(own);
}

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

namespace {

/// The cheapest way from the body to another piece, ends included.
struct Way {
  std::vector<std::size_t> samples;
  std::size_t piece = 0;

  [[nodiscard]] double length_mm(const Lattice& lattice, double voxel_mm) const {
    double out = 0;
    for (std::size_t n = 1; n < samples.size(); ++n) {
      const Index3 from = lattice.at(samples[n - 1]);
      const Index3 to = lattice.at(samples[n]);
      out += voxel_mm * std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
    }
    return out;
  }
};

/// @param piece_of [sample] 0 outside, 1 the body, above that pieces apart; one of them at least
Way way_to_next_piece(const Lattice& lattice, const std::vector<float>& samples,
                      const std::vector<std::uint32_t>& piece_of) {
  std::priority_queue<Waiting<double>> queue;
  std::vector<double> least(samples.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> from(samples.size(), samples.size());
  std::uint64_t turn = 0;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if (piece_of[n] != 1) continue;
    least[n] = 0;
    queue.push({0, turn++, n});
  }
  while (!queue.empty()) {
    const Waiting<double> next = queue.top();
    queue.pop();
    if (next.level > least[next.index]) continue;
    if (piece_of[next.index] > 1) {
      Way out;
      out.piece = piece_of[next.index];
      for (std::size_t n = next.index; n < samples.size(); n = from[n]) out.samples.push_back(n);
      return out;
    }
    lattice.around(next.index, [&](std::size_t, std::size_t to) {
      if (piece_of[to] == 1 || lattice.on_border(lattice.at(to))) return;
      // A step that costs nothing else is not free, or ways would be longer than they need be.
      constexpr double kStep = 1e-3;
      const double cost = next.level + kStep + std::max(0.0, static_cast<double>(samples[to]));
      if (!(cost < least[to])) return;
      least[to] = cost;
      from[to] = next.index;
      queue.push({cost, turn++, to});
    });
  }
  return {};  // What lies on the border alone has no way.
}

/// The samples of a way and those around them that are outside.
std::vector<std::size_t> bridge_of(const Lattice& lattice, const Way& way,
                                   const std::vector<std::uint32_t>& piece_of) {
  std::vector<std::size_t> out;
  const auto add = [&](std::size_t n) {
    if (piece_of[n] == 0 && !lattice.on_border(lattice.at(n))) out.push_back(n);
  };
  for (const std::size_t n : way.samples) {
    add(n);
    lattice.around(n, [&](std::size_t, std::size_t to) { add(to); });
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

/// [sample] 0 outside, 1 the body, which is the piece of the most samples, else number + 2 of the
/// piece.
std::vector<std::uint32_t> numbered(const std::vector<Piece>& pieces, std::size_t sample_count) {
  const auto largest = std::max_element(
      pieces.begin(), pieces.end(),
      [](const Piece& a, const Piece& b) { return a.samples.size() < b.samples.size(); });
  std::vector<std::uint32_t> piece_of(sample_count, 0);
  for (auto piece = pieces.begin(); piece != pieces.end(); ++piece) {
    const auto name =
        piece == largest ? 1U : static_cast<std::uint32_t>(piece - pieces.begin()) + 2;
    for (const std::size_t n : piece->samples) piece_of[n] = name;
  }
  return piece_of;
}

/// [mm] The least sample of a piece; 0 where none is below.
float deepest_of(const Piece& piece, const std::vector<float>& samples) {
  float deepest = 0;
  for (const std::size_t n : piece.samples) deepest = std::min(deepest, samples[n]);
  return deepest;
}

void join_pieces(const Grid& grid, const std::vector<float>& samples,
                 const std::vector<Piece>& pieces, const PiecesInCycle& cycle, Mask& inside) {
  const Lattice lattice(grid);
  std::vector<std::uint32_t> piece_of = numbered(pieces, samples.size());
  for (std::size_t left = pieces.size() - 1; left > 0; --left) {
    const Way way =
        way_to_next_piece(lattice, cycle.least_mm != nullptr ? *cycle.least_mm : samples, piece_of);
    if (way.samples.empty()) break;
    const std::size_t number = way.piece - 2;
    const Piece& piece = pieces[number];
    const float deepest = deepest_of(piece, samples);
    const bool is_joined = (number < cycle.belongs.size() && cycle.belongs[number] != 0) ||
                           way.length_mm(lattice, grid.spacing_mm().x()) < -deepest;
    for (const std::size_t n : piece.samples) piece_of[n] = is_joined ? 1 : 0;
    if (!is_joined) continue;
    for (const std::size_t n : bridge_of(lattice, way, piece_of)) piece_of[n] = 1;
  }
  for (std::size_t n = 0; n < inside.size(); ++n) inside[n] = piece_of[n] == 1 ? 1 : 0;
}

constexpr double kHalfWidth = 0.3;  // of a cut, of a sample

/// Eases the samples around one that changed side, so that a cut is as wide as it should be.
/// @param sign of the changed sample: -1 inside, 1 outside
void ease_around(const Grid& grid, const Index3& here, double sign, std::vector<float>& out) {
  constexpr int kReach = 2;
  const double voxel_mm = grid.spacing_mm().x();
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

}  // namespace

void make_one_body(const Grid& grid, const std::vector<float>& samples, Mask& inside,
                   const PiecesInCycle& cycle) {
  const Lattice lattice(grid);
  const std::vector<Piece> pieces = pieces_of(lattice, inside, 1);
  if (pieces.size() > 1) join_pieces(grid, samples, pieces, cycle, inside);
  for (const Piece& piece : pieces_of(lattice, inside, 0)) {
    if (!piece.at_border) flip(inside, piece.samples);
  }
}

std::size_t change_sides(const Grid& grid, const Mask& inside, std::vector<float>& samples) {
  const Lattice lattice(grid);
  std::size_t changed = 0;
  std::vector<float> out = samples;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if ((samples[n] < 0) == (inside[n] != 0)) continue;
    ++changed;
    ease_around(grid, lattice.at(n), inside[n] != 0 ? -1.0 : 1.0, out);
  }
  // Where a cut and a filling are neighbours each has what it was made for.
  const auto least = static_cast<float>(kHalfWidth * grid.spacing_mm().x());
  for (std::size_t n = 0; n < out.size(); ++n) {
    if (inside[n] != 0 && !(out[n] < 0)) out[n] = -least;
    if (inside[n] == 0 && out[n] < 0) out[n] = least;
  }
  if (changed > 0) samples = std::move(out);
  return changed;
}

}  // namespace beatlas::field
