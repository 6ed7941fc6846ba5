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

/// What of a ventricle's natural beat the finger on an atlas needs: the beat without a finger of
/// the parameters' circulation.
struct NaturalWall {
  double shortening_area_cm2 = 0;        ///< S_n by equation (5)
  std::vector<double> pressure_n_per_m;  ///< pi p R, evenly over the beat from end-diastole

  /// @param share of the beat, 0 at end-diastole, any finite number
  [[nodiscard]] double pressure_at(double share) const noexcept;
};
/// Settles the circulation: some milliseconds. @throws Error{InvalidInput} as Circulation
[[nodiscard]] NaturalWall natural_wall(const PalpationParameters& parameters);

/// Of the vertical element at one place: K_v + K_e(t), K_e by equation (6).
struct PatchConstants {
  double k_v_n_per_m = 0;
  double c_v_n_s_per_m = 0;
  double k_e_rest_n_per_m = 0;  ///< at Emin
  double k_e_span_n_per_m = 0;  ///< from there to the ventricle's Emax as it is

  /// @param e of ElastanceCurve, 0 at Emin, 1 at Emax
  [[nodiscard]] double n_per_m(double e) const noexcept {
    return k_v_n_per_m + contracted_n_per_m(e);
  }
  /// K_e alone.
  [[nodiscard]] double contracted_n_per_m(double e) const noexcept {
    return k_e_rest_n_per_m + k_e_span_n_per_m * e;
  }
};

/// @param shortening_area_cm2 S_n of the beat  @param long_axis 0 apex .. 1 base
[[nodiscard]] PatchConstants patch_constants(const PalpationParameters& parameters,
                                             double shortening_area_cm2, double long_axis,
                                             const Tissue& tissue) noexcept;

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
  [[nodiscard]] const NaturalWall& natural() const noexcept { return natural_; }

  /// Of a vertex.
  [[nodiscard]] const PatchConstants& as_it_is(std::uint32_t vertex) const noexcept {
    return as_it_is_[vertex];
  }

  /// A tick's: the muscle under a place of the heart's surface. Over the right ventricle, the atria
  /// and the vessels: healthy, as at the long axis beside them. @param beats as LvWall::nearest
  [[nodiscard]] const PatchConstants& under(const Vec3& mm, double beats,
                                            LvWall::Trail& trail) const noexcept;

  /// Whether a place's wall is what is touched there.
  [[nodiscard]] bool reaches(const WallPlace& place, double beats) const noexcept;

 private:
  std::shared_ptr<const LvWall> wall_;
  TissueMap tissue_;
  NaturalWall natural_;
  std::vector<PatchConstants> as_it_is_;  ///< [vertex]
  std::vector<PatchConstants> healthy_;   ///< [vertex]
};

}  // namespace beatlas::palpation
