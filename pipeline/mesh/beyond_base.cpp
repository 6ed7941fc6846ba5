#include "pipeline/mesh/beyond_base.h"

#include <algorithm>
#include <array>

#include "pipeline/core/parallel.h"
#include "pipeline/field/interpolant.h"
#include "runtime/atlas/structures.h"

namespace beatlas::mesh {

FieldCycle without_ventricles(const FieldCycle& field, const std::vector<FieldCycle>& all,
                              double edge_mm) {
  constexpr double kGap = 0.05;  // of an edge
  constexpr std::array kVentricles{Structure::LvBlood, Structure::LvMyocardium, Structure::RvBlood};
  FieldCycle out = field;
  const Grid& grid = field.distance_mm.grid;
  const auto gap_mm = static_cast<float>(kGap * edge_mm);
  parallel_for(out.distance_mm.phases.size(), [&](std::size_t p) {
    std::vector<float>& distance = out.distance_mm.phases[p];
    for (const FieldCycle& other : all) {
      if (std::find(kVentricles.begin(), kVentricles.end(), other.structure) == kVentricles.end()) {
        continue;
      }
      const field::Interpolant ventricle(other.distance_mm.grid, other.distance_mm.phases[p]);
      std::size_t at = 0;
      for (int k = 0; k < grid.size[2]; ++k) {
        for (int j = 0; j < grid.size[1]; ++j) {
          for (int i = 0; i < grid.size[0]; ++i, ++at) {
            if (distance[at] >= gap_mm + static_cast<float>(other.inner_mm)) continue;
            const auto away = static_cast<float>(ventricle.value(grid.mm(i, j, k)));
            distance[at] = std::max(distance[at], gap_mm - away);
          }
        }
      }
    }
  });
  return out;
}

}  // namespace beatlas::mesh
