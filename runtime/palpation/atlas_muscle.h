#pragma once
/// The muscle under a finger that goes where it likes on an atlas: paper B's, blended along the
/// long axis of the atlas's own left ventricle, as ill as the place is.

#include <cstdint>
#include <memory>
#include <vector>

#include "runtime/palpation/lv_wall.h"
#include "runtime/palpation/parameters.h"
#include "runtime/palpation/regions.h"

namespace beatlas::palpation {

/// Of the vertical element at one place: K_v + K_e(t), K_e by equation (6).
struct PatchConstants {
  double k_v_n_per_m = 0;
  double c_v_n_s_per_m = 0;
  double k_e_rest_n_per_m = 0;  ///< at Emin
  double k_e_span_n_per_m = 0;  ///< from there to the ventricle's Emax as it is
};

/// @param long_axis 0 apex .. 1 base
[[nodiscard]] PatchConstants patch_constants(const PalpationParameters& parameters,
                                             double long_axis, const Tissue& tissue) noexcept;

/// The left ventricle's muscle, place by place. Immutable; looked at by any thread.
class AtlasMuscle {
 public:
  /// Fat, the pericardium and what errors leave between a wall's outside and the heart's surface
  /// [mm]; where more lies between, it is another part of the heart that is touched.
  static constexpr double kOutsideMm = 8;

  /// @param tissue of the wall's vertices
  /// @throws Error{InvalidInput} if there is no wall, the tissue is of another number of vertices,
  /// or a parameter is out of range.
  AtlasMuscle(std::shared_ptr<const LvWall> wall, TissueMap tissue,
              const PalpationParameters& parameters);

  [[nodiscard]] const LvWall& wall() const noexcept { return *wall_; }
  [[nodiscard]] const TissueMap& tissue() const noexcept { return tissue_; }

  /// A tick's: the muscle under a place of the heart's surface. Over the right ventricle, the atria
  /// and the vessels: healthy, as at the long axis beside them. @param beats as LvWall::nearest
  [[nodiscard]] const PatchConstants& under(const Vec3& mm, double beats,
                                            LvWall::Trail& trail) const noexcept;

  /// Whether a place's wall is what is touched there.
  [[nodiscard]] bool reaches(const WallPlace& place, double beats) const noexcept;

 private:
  std::shared_ptr<const LvWall> wall_;
  TissueMap tissue_;
  std::vector<PatchConstants> as_it_is_;  ///< [vertex]
  std::vector<PatchConstants> healthy_;   ///< [vertex]
};

}  // namespace beatlas::palpation
