#include "runtime/palpation/atlas_muscle.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/palpation/circulation.h"

namespace beatlas::palpation {

double NaturalWall::pressure_at(double share) const noexcept {
  const auto count = static_cast<double>(pressure_n_per_m.size());
  const double along = (share - std::floor(share)) * count;
  const double place = along >= 0 && along < count ? along : 0;  // a time that is no number
  const auto at = static_cast<std::size_t>(place) % pressure_n_per_m.size();
  const double before = pressure_n_per_m[at];
  const double after = pressure_n_per_m[(at + 1) % pressure_n_per_m.size()];
  return before + (place - std::floor(place)) * (after - before);
}

NaturalWall natural_wall(const PalpationParameters& parameters) {
  constexpr double kStepS = 1e-3;
  Circulation circulation(parameters.whole_circulation());
  circulation.settle(kStepS);
  const CirculationParameters& p = circulation.parameters();
  NaturalWall out;
  out.shortening_area_cm2 =
      shortening_area_cm2(circulation.last_beat().contracting_ml, p.reference_volume_ml);
  const double period_s = 60 / p.heart_rate_per_min;
  const auto steps = static_cast<int>(std::ceil(period_s / kStepS));
  for (int n = 0; n < steps; ++n) {
    out.pressure_n_per_m.push_back(pressure_n_per_m(circulation));
    circulation.tick(period_s / steps, -1);
  }
  return out;
}

PatchConstants patch_constants(const PalpationParameters& parameters, double shortening_area_cm2,
                               double long_axis, const Tissue& tissue) noexcept {
  const MuscleConstants muscle = parameters.at(long_axis, tissue);
  const CirculationParameters circulation = parameters.whole_circulation();
  const double rest =
      parameters.contractile.stiffness_n_per_m(tissue.alpha, shortening_area_cm2, circulation.emin);
  return {.k_v_n_per_m = muscle.k_v_n_per_m,
          .c_v_n_s_per_m = muscle.c_v_n_s_per_m,
          .k_e_rest_n_per_m = rest,
          .k_e_span_n_per_m = parameters.contractile.stiffness_n_per_m(
                                  tissue.alpha, shortening_area_cm2, circulation.effective_emax()) -
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
  natural_ = natural_wall(parameters);
  for (std::size_t v = 0; v < wall_->vertex_count(); ++v) {
    const auto long_axis = static_cast<double>(wall_->map().long_axis[v]);
    as_it_is_.push_back(
        patch_constants(parameters, natural_.shortening_area_cm2, long_axis, tissue_.of_vertex[v]));
    healthy_.push_back(patch_constants(parameters, natural_.shortening_area_cm2, long_axis, {}));
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
