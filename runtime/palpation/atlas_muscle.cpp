#include "runtime/palpation/atlas_muscle.h"

#include <algorithm>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::palpation {

PatchConstants patch_constants(const PalpationParameters& parameters, double long_axis,
                               const Tissue& tissue) noexcept {
  const MuscleConstants muscle = parameters.at(long_axis, tissue);
  const CirculationParameters circulation = parameters.whole_circulation();
  const double rest = parameters.contractile.stiffness_n_per_m(tissue.alpha, circulation.emin);
  return {.k_v_n_per_m = muscle.k_v_n_per_m,
          .c_v_n_s_per_m = muscle.c_v_n_s_per_m,
          .k_e_rest_n_per_m = rest,
          .k_e_span_n_per_m =
              parameters.contractile.stiffness_n_per_m(tissue.alpha, circulation.effective_emax()) -
              rest};
}

AtlasMuscle::AtlasMuscle(std::shared_ptr<const LvWall> wall, TissueMap tissue,
                         const PalpationParameters& parameters)
    : wall_(std::move(wall)), tissue_(std::move(tissue)) {
  if (!wall_) throw_invalid("the atlas has no map of the LV's wall; build it again from images");
  if (tissue_.of_vertex.size() != wall_->vertex_count()) {
    throw_invalid("the tissue is of another wall than the atlas's");
  }
  parameters.check();
  for (std::size_t v = 0; v < wall_->vertex_count(); ++v) {
    const auto long_axis = static_cast<double>(wall_->map().long_axis[v]);
    as_it_is_.push_back(patch_constants(parameters, long_axis, tissue_.of_vertex[v]));
    healthy_.push_back(patch_constants(parameters, long_axis, {}));
  }
}

bool AtlasMuscle::reaches(const WallPlace& place, double beats) const noexcept {
  if (!(place.wall_mm > 0)) return false;
  const double now_mm = std::max(place.wall_mm, wall_->wall_mm_at(place.vertex, beats));
  return place.away_mm <= now_mm + kOutsideMm;  // in systole it is thicker
}

const PatchConstants& AtlasMuscle::under(const Vec3& mm, double beats,
                                         LvWall::Trail& trail) const noexcept {
  const WallPlace place = wall_->follow(mm, beats, trail);
  return reaches(place, beats) ? as_it_is_[place.vertex] : healthy_[place.vertex];
}

}  // namespace beatlas::palpation
