#pragma once
/// What simple_topology.cpp, cycle_topology.cpp and repair_topology.cpp share: masks on the
/// Freudenthal triangulation of a lattice, where each sample has 14 neighbours.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::field {

constexpr std::size_t kNeighbours = 14;

/// The steps to a sample's neighbours: to the other corners of a cube that lie along a monotone
/// path, and back.
constexpr std::array<Index3, kNeighbours> make_steps() {
  std::array<Index3, kNeighbours> out{};
  for (int bits = 1; bits < 8; ++bits) {
    const Index3 ahead{bits & 1, bits >> 1 & 1, bits >> 2 & 1};
    out[static_cast<std::size_t>(bits) - 1] = ahead;
    out[static_cast<std::size_t>(bits) + 6] = {-ahead[0], -ahead[1], -ahead[2]};
  }
  return out;
}
inline constexpr std::array<Index3, kNeighbours> kNeighbourSteps = make_steps();

/// 1 for each sample that is inside.
using Mask = std::vector<std::uint8_t>;
[[nodiscard]] Mask inside_of(const std::vector<float>& samples);
/// Changes the side of some samples.
void flip(Mask& inside, const std::vector<std::size_t>& samples);

class Lattice {
 public:
  explicit Lattice(const Grid& grid) : size_(grid.size) {
    for (std::size_t n = 0; n < kNeighbours; ++n) {
      offset_[n] = static_cast<std::ptrdiff_t>(kNeighbourSteps[n][0]) +
                   size_[0] * (kNeighbourSteps[n][1] +
                               static_cast<std::ptrdiff_t>(size_[1]) * kNeighbourSteps[n][2]);
    }
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
          const int to = here[axis] + kNeighbourSteps[n][axis];
          within = within && to >= 0 && to < size_[axis];
        }
        if (!within) continue;
      }
      visit(n, static_cast<std::size_t>(static_cast<std::ptrdiff_t>(index) + offset_[n]));
    }
  }
  /// Whether a sample may change side and inside and outside stay what they are: both are one
  /// piece around it (Bertrand 1994).
  /// @param beyond whether what lies beyond the lattice is set
  [[nodiscard]] bool is_simple(const Mask& set, std::size_t index, bool beyond) const;
  /// Whether a sample of the set joins what is in pieces around it.
  [[nodiscard]] bool is_thread(const Mask& set, std::size_t index) const;

 private:
  Index3 size_;
  std::array<std::ptrdiff_t, kNeighbours> offset_{};
};

/// A sample that waits its turn in a std::priority_queue: the least level first, of equal ones the
/// one that came first, so that the order is the same on any machine.
template <class Level>
struct Waiting {
  Level level{};
  std::uint64_t turn = 0;
  std::size_t index = 0;

  bool operator<(const Waiting& other) const {
    return level != other.level ? level > other.level : turn > other.turn;
  }
};

/// A piece of the samples of one side.
struct Piece {
  std::vector<std::size_t> samples;
  bool at_border = false;
};
[[nodiscard]] std::vector<Piece> pieces_of(const Lattice& lattice, const Mask& inside,
                                           std::uint8_t side);

/// What the other phases of a cycle say of one phase's pieces.
struct PiecesInCycle {
  std::vector<std::uint8_t> belongs;     ///< [piece] 1: part of the body, however far from it
  const std::vector<float>* least_mm{};  ///< [sample] the least of all phases; null: no others
};

/// Makes the inside one piece without hollows. Beside the piece of the most samples each other, the
/// nearest first, is joined to it where it belongs to it or is deeper than the way to it is long,
/// and goes where it is not. Labels of slices far apart lose the neck by which a part hangs on, as
/// the outflow tract on the right ventricle, and the part is there all the same; what is farther
/// away than it is deep is a slip of the labels. The way is that over the least sum of samples,
/// where the neck is in any phase, with the samples around it, so that triangles have room there.
/// @param samples distances [mm] on `grid`  @param cycle of the pieces of `inside`, see pieces_of
void make_one_body(const Grid& grid, const std::vector<float>& samples, Mask& inside,
                   const PiecesInCycle& cycle = {});

/// Gives samples the side that they have in the mask and eases those around, so that a cut is about
/// 0.6 of a sample wide.
/// @return how many changed side
std::size_t change_sides(const Grid& grid, const Mask& inside, std::vector<float>& samples);

}  // namespace beatlas::field
