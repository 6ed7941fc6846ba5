#include "pipeline/segment/thin_walls.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/core/box.h"
#include "pipeline/core/distance_map.h"
#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "runtime/atlas/structures.h"

namespace beatlas::segment {
namespace {

constexpr double kThickestMm = 5;

constexpr std::array kThinWalled{kLabelRvBlood, kLabelLaBlood, kLabelRaBlood, kLabelAorta};

bool has_thin_wall(std::uint8_t label) {
  return std::find(kThinWalled.begin(), kThinWalled.end(), label) != kThinWalled.end();
}

/// Of voxels beside the pool, by faces, the way into it; from there on through what is muscle.
void walk(const Grid& grid, bool across_slices, const std::vector<std::uint8_t>& wall,
          std::vector<std::size_t> front, std::vector<std::uint8_t>& labels) {
  const int axes = across_slices ? 3 : 2;
  while (!front.empty()) {
    const std::size_t v = front.back();
    front.pop_back();
    const Index3 at = index_of(grid, v);
    for (int a = 0; a < axes; ++a) {
      for (const int step : {-1, 1}) {
        Index3 to = at;
        to[static_cast<std::size_t>(a)] += step;
        if (!grid.contains(to[0], to[1], to[2])) continue;
        const std::size_t next = grid.offset(to[0], to[1], to[2]);
        if (wall[next] == 0 || labels[next] != kLabelBackground) continue;
        labels[next] = kLabelRestOfHeart;
        front.push_back(next);
      }
    }
  }
}

}  // namespace

void add_thin_walls(const ImageCycle<float>& images, const tissue::TissueLevels& levels,
                    ImageCycle<std::uint8_t>& labels) {
  const Grid& grid = labels.grid;
  const bool across_slices = !are_thick_slices(grid.spacing_mm()[2]);
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    std::vector<std::uint8_t>& phase = labels.phases[p];
    std::vector<std::uint8_t> pools(phase.size());
    std::vector<std::size_t> front;
    for (std::size_t v = 0; v < phase.size(); ++v) {
      pools[v] = static_cast<std::uint8_t>(has_thin_wall(phase[v]));
      if (pools[v] != 0) front.push_back(v);
    }
    const std::vector<float> away = distance_near(grid, pools, across_slices, kThickestMm);
    std::vector<std::uint8_t> wall(phase.size());
    for (std::size_t v = 0; v < phase.size(); ++v) {
      const auto value = static_cast<double>(images.phases[p][v]);
      wall[v] = static_cast<std::uint8_t>(phase[v] == kLabelBackground && away[v] <= kThickestMm &&
                                          value > levels.dark && value < levels.threshold);
    }
    walk(grid, across_slices, wall, std::move(front), phase);
  });
}

void reach_walls(const ImageCycle<float>& images, const tissue::TissueLevels& levels,
                 double pixel_mm, ImageCycle<std::uint8_t>& labels) {
  const Grid& grid = labels.grid;
  // From the outermost centres, off which the outline lies by half a pixel of the images.
  const double reach_mm = pixel_mm + grid.spacing_mm().head<2>().maxCoeff() / 2;
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    std::vector<std::uint8_t>& phase = labels.phases[p];
    const std::vector<std::uint8_t> before = phase;
    std::vector<float> nearest(phase.size(), kNoDistance);  // of the cavities
    for (const std::uint8_t cavity : kThinWalled) {
      const bool right = cavity == kLabelRvBlood || cavity == kLabelRaBlood;
      const double blood = right ? levels.rv_blood : levels.blood;
      const auto is_blood = [&](float value) {
        const auto level = static_cast<double>(value);
        return std::abs(level - blood) < std::abs(level - levels.muscle);
      };
      std::vector<std::uint8_t> pool(phase.size());
      std::transform(before.begin(), before.end(), pool.begin(), [&](std::uint8_t label) {
        return static_cast<std::uint8_t>(label == cavity);
      });
      const std::vector<float> away = distance_near(grid, pool, false, reach_mm);
      for (std::size_t v = 0; v < phase.size(); ++v) {
        if (before[v] != kLabelRestOfHeart || !is_blood(images.phases[p][v])) continue;
        if (static_cast<double>(away[v]) > reach_mm || away[v] >= nearest[v]) continue;
        nearest[v] = away[v];
        phase[v] = cavity;
      }
    }
  });
}

}  // namespace beatlas::segment
