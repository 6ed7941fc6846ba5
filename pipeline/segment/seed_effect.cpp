#include "pipeline/segment/seed_effect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "pipeline/segment/box.h"

namespace beatlas::segment {
namespace {

using Marks = std::vector<std::vector<std::uint8_t>>;  // [phase][voxel], 1: changed

Marks changes(const LabelCycle& before, const LabelCycle& after) {
  Marks out(before.phases.size());
  for (std::size_t p = 0; p < out.size(); ++p) {
    out[p].resize(before.phases[p].size());
    for (std::size_t v = 0; v < out[p].size(); ++v) {
      out[p][v] = before.phases[p][v] != after.phases[p][v] ? 1 : 0;
    }
  }
  return out;
}

struct Place {
  std::size_t phase = 0;
  std::size_t voxel = 0;
};

/// Takes marks away that hang together with those in the seed's ball.
class Lump {
 public:
  Lump(const Grid& grid, Marks& marks) : grid_(grid), marks_(marks) {}

  void take(const LeakSeed& seed) {
    const Affine index_from_mm = grid_.mm_from_index.inverse();
    const Vec3 middle = index_from_mm * seed.lps_mm;
    const Vec3 reach = grid_.spacing_mm().cwiseInverse() * seed.radius_mm;
    std::array<int, 3> low{};
    std::array<int, 3> high{};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<int>(a);
      low[a] = std::max(0, static_cast<int>(std::lround(middle[axis] - reach[axis])));
      high[a] =
          std::min(grid_.size[a] - 1, static_cast<int>(std::lround(middle[axis] + reach[axis])));
    }
    for (std::size_t p = 0; p < marks_.size(); ++p) {
      if (seed.phase >= 0 && p != static_cast<std::size_t>(seed.phase)) continue;
      for (int k = low[2]; k <= high[2]; ++k) {
        for (int j = low[1]; j <= high[1]; ++j) {
          for (int i = low[0]; i <= high[0]; ++i) take_one(p, grid_.offset(i, j, k));
        }
      }
    }
    while (!waiting_.empty()) {
      const Place at = waiting_.back();
      waiting_.pop_back();
      take_beside(at);
    }
  }

 private:
  void take_one(std::size_t phase, std::size_t voxel) {
    if (marks_[phase][voxel] == 0) return;
    marks_[phase][voxel] = 0;
    waiting_.push_back({phase, voxel});
  }

  void take_beside(const Place& at) {
    const Index3 index = index_of(grid_, at.voxel);
    for (std::size_t a = 0; a < 3; ++a) {
      for (const int step : {-1, 1}) {
        Index3 beside = index;
        beside[a] += step;
        if (beside[a] < 0 || beside[a] >= grid_.size[a]) continue;
        take_one(at.phase, grid_.offset(beside[0], beside[1], beside[2]));
      }
    }
    const std::size_t n = marks_.size();
    take_one((at.phase + 1) % n, at.voxel);
    take_one((at.phase + n - 1) % n, at.voxel);
  }

  const Grid& grid_;
  Marks& marks_;
  std::vector<Place> waiting_;
};

}  // namespace

double changed_elsewhere_ml(const LabelCycle& before, const LabelCycle& after,
                            const std::vector<LeakSeed>& seeds) {
  Marks marks = changes(before, after);
  Lump lump(before.grid, marks);
  for (const LeakSeed& seed : seeds) lump.take(seed);
  long most = 0;
  for (std::size_t p = 0; p < marks.size(); ++p) {
    std::array<long, 256> gained{};
    for (std::size_t v = 0; v < marks[p].size(); ++v) {
      if (marks[p][v] == 0) continue;
      --gained[before.phases[p][v]];
      ++gained[after.phases[p][v]];
    }
    for (const long voxels : gained) most = std::max(most, std::labs(voxels));
  }
  return static_cast<double>(most) * before.grid.voxel_ml();
}

}  // namespace beatlas::segment
