#include "pipeline/segment/open_base.h"

#include <cmath>

#include "pipeline/core/parallel.h"
#include "runtime/atlas/structures.h"

namespace beatlas::segment {
namespace {

constexpr double kFilmVoxels =
    1.25;  ///< along the axis, how far below a film the blood is looked for

/// Where the cavity ends openly, voxels that are half blood are as dark as muscle: a film across
/// the mouth, hardly a voxel thick, that has blood and no wall below it along the axis.
void clear_film_over_mouth(const Chambers& chambers, ImageCycle<std::uint8_t>& labels) {
  const Grid& grid = labels.grid;
  const Vec3 along = grid.mm_from_index.linear().transpose() * chambers.axis->towards_base;
  const double voxel_mm = along.cwiseAbs().sum();  // what a voxel spans along the axis
  const Vec3 below = grid.mm_from_index.linear().inverse() *
                     (-kFilmVoxels * voxel_mm * chambers.axis->towards_base);
  const Index3 step{static_cast<int>(std::lround(below[0])),
                    static_cast<int>(std::lround(below[1])),
                    static_cast<int>(std::lround(below[2]))};
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    const std::vector<std::uint8_t> was = labels.phases[p];
    const double lowest = chambers.axis->lv_base_mm[p] - 2 * kFilmVoxels * voxel_mm;
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const std::size_t v = grid.offset(i, j, k);
          if (was[v] != kLabelLvMyocardium || chambers.height_mm[v] < lowest) continue;
          const auto label_at = [&](int steps) -> std::uint8_t {
            const Index3 at{i + steps * step[0], j + steps * step[1], k + steps * step[2]};
            if (!grid.contains(at[0], at[1], at[2])) return kLabelBackground;
            return was[grid.offset(at[0], at[1], at[2])];
          };
          const std::uint8_t above = label_at(-1);
          if (label_at(1) != kLabelLvBlood || above == kLabelLvBlood ||
              above == kLabelLvMyocardium) {
            continue;
          }
          labels.phases[p][v] = kLabelRestOfHeart;
        }
      }
    }
  });
}

}  // namespace

void cut_at_base(const Chambers& chambers, ImageCycle<std::uint8_t>& labels) {
  if (chambers.axis && !chambers.axis->atria) clear_film_over_mouth(chambers, labels);
  if (!chambers.parts_atria()) return;
  for (std::size_t p = 0; p < labels.phases.size(); ++p) {
    const auto base = static_cast<float>(chambers.axis->lv_base_mm[p]);
    for (std::size_t v = 0; v < labels.phases[p].size(); ++v) {
      std::uint8_t& label = labels.phases[p][v];
      if (chambers.height_mm[v] > base && (label == kLabelLvBlood || label == kLabelLvMyocardium)) {
        label = kLabelRestOfHeart;
      }
    }
  }
}

}  // namespace beatlas::segment
