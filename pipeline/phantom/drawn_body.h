#pragma once
/// What lies around a heart of the family: chest, lungs, diaphragm, belly, vessels, and organs at
/// random that may be taken for a heart.
///
/// Patient frame LPS [mm], origin at the heart's middle.

#include <array>
#include <optional>
#include <vector>

#include "pipeline/phantom/drawn_heart.h"

namespace beatlas::phantom {

class DrawnBody {
 public:
  /// @param heart_reach [mm] radius of the ball about the origin in which the heart lies
  DrawnBody(const Family& family, float heart_reach);

  [[nodiscard]] Tissue at(const Vec3F& lps) const;

 private:
  struct Organ {
    Vec3F centre = Vec3F::Zero();
    Vec3F per_axis = Vec3F::Ones();  ///< one over its axes
    Tissue core = Tissue::OtherA;
    Tissue shell = Tissue::OtherA;
    float shell_from = 1;  ///< share of the radius at which the shell begins
  };

  struct Kidney {
    Vec3F centre = Vec3F::Zero();
    float radius = 25;  ///< [mm] across; its length is nearly twice as much
  };

  /// Beyond the chest's skin. @param past_side x over the chest's width  @param y from its middle
  [[nodiscard]] Tissue beyond_chest(float past_side, float y) const;
  /// Between skin fat and ribs. @param rough as abdomen's
  [[nodiscard]] Tissue in_chest_wall(const Vec3F& lps, float rough) const;
  /// What of the organs at random is at a place. @param rough as abdomen's
  [[nodiscard]] std::optional<Tissue> in_organ(const Vec3F& lps, float rough) const;
  /// Between and in the lungs. @param x from the chest's middle  @param rough as abdomen's
  [[nodiscard]] Tissue among_lungs(const Vec3F& lps, float x, float rough) const;
  /// Below the diaphragm. @param rough smooth noise in [-1, 1]
  [[nodiscard]] Tissue abdomen(const Vec3F& lps, float rough) const;

  std::uint32_t seed_;
  Vec3F chest_ = Vec3F::Zero();  ///< the chest's middle line passes through it
  float width_ = 0, depth_ = 0, skin_ = 0, muscle_ = 0;
  float spine_radius_ = 20, descending_ = 10, column_ = 25, diaphragm_ = 0, liver_to_ = 0;
  float fat_pad_ = 0;        ///< share of the lung beside the heart that is fat
  float fat_pad_reach_ = 1;  ///< mm from the heart's middle
  Vec3F spine_ = Vec3F::Zero();
  Vec3F aorta_ = Vec3F::Zero();
  Vec3F stomach_ = Vec3F::Zero();
  float stomach_radius_ = 40, stomach_wall_ = 4, gas_above_ = 0;
  std::array<Kidney, 2> kidneys_;
  float cortex_ = 8, loop_ = 30, loop_wall_ = 3;  ///< [mm]
  bool arms_ = false;
  std::vector<Organ> organs_;
};

}  // namespace beatlas::phantom
