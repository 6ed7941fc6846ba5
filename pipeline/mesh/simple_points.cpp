#include "pipeline/mesh/simple_points.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace beatlas::mesh {
namespace {

constexpr std::uint32_t kAll = (1U << kNeighbours) - 1;

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

void keep_one_body(const Lattice& lattice, Mask& inside) {
  const std::vector<Piece> pieces = pieces_of(lattice, inside, 1);
  const auto largest = std::max_element(
      pieces.begin(), pieces.end(),
      [](const Piece& a, const Piece& b) { return a.samples.size() < b.samples.size(); });
  for (auto piece = pieces.begin(); piece != pieces.end(); ++piece) {
    if (piece != largest) flip(inside, piece->samples);
  }
  for (const Piece& piece : pieces_of(lattice, inside, 0)) {
    if (!piece.at_border) flip(inside, piece.samples);
  }
}

std::size_t change_sides(const Grid& grid, const Mask& inside, std::vector<float>& samples) {
  constexpr double kHalfWidth = 0.3;  // of a sample
  constexpr int kReach = 2;
  const double voxel_mm = grid.spacing_mm().x();
  const Lattice lattice(grid);
  std::size_t changed = 0;
  std::vector<float> out = samples;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if ((samples[n] < 0) == (inside[n] != 0)) continue;
    ++changed;
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
  if (changed > 0) samples = std::move(out);
  return changed;
}

}  // namespace beatlas::mesh
