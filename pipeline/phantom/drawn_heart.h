#pragma once
/// A heart of the family as an implicit body: which tissue lies at a place in a moment of the beat.
///
/// Heart frame [mm]: origin at the middle of the mitral plane at end-diastole, +z to the LV's apex,
/// +x from the LV's axis to the middle of the RV, +y = z cross x (the diaphragm's side). The apex
/// stays, the base descends. Distances within are first-order (a level over its gradient), exact on
/// the surface: good for drawing images and labels, not for measuring a millimetre's tenth.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "pipeline/phantom/family.h"

namespace beatlas::phantom {

using Vec3F = Eigen::Vector3f;

/// What a place is made of; its signal is drawn by name.
enum class Tissue : std::uint8_t {
  Outside,
  Fat,
  ChestMuscle,
  Bone,
  Lung,
  Liver,
  Spleen,
  Stomach,
  Gas,
  Vessel,
  Mediastinum,
  OtherA,
  OtherB,
  OtherC,
  OtherD,
  Effusion,
  Pericardium,
  LvBlood,
  LvMuscle,
  Papillary,
  RvBlood,
  RvTrabecula,
  Wall,
  LaBlood,
  RaBlood,
  Aorta,
  Trunk,
  Count
};

/// Label (see atlas Label) of a tissue: 0 for all that is not of the heart.
[[nodiscard]] std::uint8_t label_of(Tissue tissue);

/// Smooth noise in [-1, 1] with features of unit size: values on a lattice, hashed and
/// interpolated.
[[nodiscard]] float lattice_noise(const Vec3F& at, std::uint32_t seed);
/// Its value at a place of the lattice itself. @pre whole numbers
[[nodiscard]] float lattice_value(const Vec3F& corner, std::uint32_t seed);

class DrawnHeart {
 public:
  explicit DrawnHeart(const Family& family);

  /// All that hangs on the moment alone. `contraction` 0 at end-diastole, 1 at end-systole.
  struct Moment {
    float contraction = 0;
    float base = 0;       ///< [mm] height of the mitral plane
    float tricuspid = 0;  ///< [mm] of the tricuspid plane
    float length = 0;     ///< [mm] of the cavity, base to apex
    float radial = 1;     ///< the cavity's radius over that at end-diastole
    float wall_gain = 1;  ///< end-diastolic over present length: muscle keeps its volume
    float rv_depth = 1;   ///< the RV's depth over that at end-diastole
    float atria = 1;      ///< the atria's size over that at end-diastole
  };
  [[nodiscard]] Moment moment(float contraction) const;

  /// The heart's tissue at a place; Tissue::Outside where the heart and its fat are not.
  [[nodiscard]] Tissue at(const Vec3F& place, const Moment& moment) const;

  [[nodiscard]] Vec3F middle() const { return {0.3F * rv_reach_, 0, 0.3F * length_}; }
  /// [mm] A ball of this radius about `middle` holds the heart and its fat.
  [[nodiscard]] float reach() const { return reach_; }
  [[nodiscard]] float length() const { return length_; }

 private:
  struct Ventricle {
    float inner = 0;   ///< [mm] distance from the LV's cavity, negative inside
    float outer = 0;   ///< from the LV's outside
    float share = 0;   ///< height over the cavity's length, 0 base, 1 apex
    float cosine = 1;  ///< of the angle from +x
    float sine = 0;
  };
  [[nodiscard]] Ventricle left(const Vec3F& place, const Moment& moment) const;
  /// A place as the LV and the valves, which move, see it.
  struct Sight {
    Vec3F place = Vec3F::Zero();  ///< [mm]
    Ventricle lv;
    float gap = 0;        ///< [mm] by which the muscle ends short of the mitral plane
    float mitral = 0;     ///< [mm] from the mitral plane toward the apex, negative beyond it
    float tricuspid = 0;  ///< [mm] the same from the tricuspid plane
    /// [mm] As it was at end-diastole, for what goes half of the mitral valve's way: LA and veins.
    Vec3F with_mitral = Vec3F::Zero();
    Vec3F with_tricuspid = Vec3F::Zero();  ///< the same for the RV's outflow tract and the RA
  };
  [[nodiscard]] Sight sight(const Vec3F& place, const Moment& moment) const;
  /// Of a place on the apex's side of the mitral plane; none where the LV alone does not tell it.
  [[nodiscard]] std::optional<Tissue> of_left(const Sight& at, const Moment& moment) const;
  /// Of a place within the LV's cavity: blood, or muscle that stands in it.
  [[nodiscard]] Tissue in_left(const Sight& at, const Moment& moment) const;
  /// Of a place within the RV, `blood` [mm] from its blood: that, or muscle that stands in it.
  [[nodiscard]] Tissue in_right(const Sight& at, float blood) const;
  [[nodiscard]] bool in_vein(const Sight& at) const;
  /// [mm] Distances from the blood of RV, LA and RA, negative inside; 1000 where it cannot be near.
  [[nodiscard]] float from_right(const Sight& at, const Moment& moment) const;
  [[nodiscard]] float from_left_atrium(const Sight& at, const Moment& moment) const;
  [[nodiscard]] float from_right_atrium(const Sight& at, const Moment& moment) const;
  /// Of a place that lies `outside` [mm] of the heart's walls.
  [[nodiscard]] Tissue around(const Sight& at, float outside) const;
  [[nodiscard]] float rv_depth(float share, float cosine, float sine) const;
  /// [mm] Distance from the LV's outflow tract.
  [[nodiscard]] float lvot(const Vec3F& place, const Moment& moment) const;
  [[nodiscard]] float scar(float share, float cosine, float sine) const;
  void size_left(const Family& family);
  void size_right(const Family& family);
  void place_beyond(const Family& family);

  struct Tube {
    Vec3F from = Vec3F::Zero();
    Vec3F to = Vec3F::Zero();
    float radius = 0;
    [[nodiscard]] float distance(const Vec3F& at) const {
      return (at - from - along(at) * (to - from)).norm() - radius;
    }
    /// 0 at `from`, 1 at `to`.
    [[nodiscard]] float along(const Vec3F& at) const {
      const Vec3F way = to - from;
      return std::clamp((at - from).dot(way) / way.squaredNorm(), 0.0F, 1.0F);
    }
  };
  struct Ball {
    Vec3F centre = Vec3F::Zero();
    Vec3F axes = Vec3F::Ones();
    /// [mm] First-order distance. @param grown factor of the axes
    [[nodiscard]] float distance(const Vec3F& at, float grown) const {
      const Vec3F unit = (at - centre).cwiseQuotient(axes * grown);
      const float length = unit.norm();
      if (length < 1e-3F) return -axes.minCoeff() * grown;
      return (length - 1) * length / unit.cwiseQuotient(axes * grown).norm();
    }
  };

  std::uint32_t seed_;
  // LV
  float length_ = 0, radius_ = 0, exponent_ = 2, bend_x_ = 0, bend_y_ = 0, narrowing_ = 0;
  float lobe2_ = 0, lobe2_angle_ = 0, lobe3_ = 0, lobe3_angle_ = 0, flattening_ = 0, bumps_ = 0;
  float radial_loss_ = 0, mapse_ = 0, tilt_x_ = 0, tilt_y_ = 0;
  float wall_ = 0, uneven1_ = 0, uneven1_angle_ = 0, uneven2_ = 0, uneven2_angle_ = 0;
  float wall_apex_ = 1, gap_ = 0, gap_angle_ = 0, gap_sharpness_ = 1, lvot_bulge_ = 0,
        lvot_rise_ = 0;
  bool infarct_ = false;
  float scar_angle_ = 0, scar_share_ = 0, scar_width_ = 1, scar_height_ = 1, scar_thin_ = 0,
        scar_still_ = 0;
  bool smooth_ = false;  ///< neither trabeculae nor papillary muscles
  float trabeculae_ = 0, trabeculae_density_ = 0;
  std::vector<Tube> papillary_;  ///< at end-diastole
  // RV
  float rv_depth_ = 0, rv_half_angle_ = 1, rv_roundness_ = 1, rv_length_ = 1, rv_loss_ = 0;
  float tapse_ = 0, tricuspid_ = 0, rv_wall_ = 0, rv_trabeculae_ = 0;
  float rv_reach_ = 0, rv_lean_ = 0, rv_taper_ = 1, rv_tilt_x_ = 0, rv_tilt_y_ = 0;
  float rv_narrowing_ = 0;  ///< of the arc over which the RV leans on the LV, toward its apex
  std::array<Tube, 2> outflow_{};
  // Beyond the base
  Ball la_, ra_;
  bool bare_ = false;  ///< no atria, no great vessels
  float filling_ = 0, atrium_wall_ = 2, mouth_ = 12;
  Tube lvot_;  ///< to the aortic valve
  std::array<Tube, 2> aorta_{};
  std::vector<Tube> veins_;
  // Around
  float fat_ = 0, groove_fat_ = 0, effusion_ = 0, pericardium_ = 1;
  float beside_ = 0;  ///< [mm] beside the ventricles the heart and its fat reach no farther
  float reach_ = 0;
};

}  // namespace beatlas::phantom
