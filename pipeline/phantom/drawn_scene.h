#pragma once
/// A heart of the family in its body, or a body without one, as a stack cuts it.

#include <cstdint>
#include <vector>

#include "pipeline/phantom/drawn_body.h"
#include "pipeline/phantom/drawn_stack.h"

namespace beatlas::phantom {

struct DrawnScene {
  const DrawnHeart* heart = nullptr;  ///< null: a body without a heart
  const DrawnBody* body = nullptr;
  Eigen::Matrix3f axes = Eigen::Matrix3f::Identity();  ///< see heart_axes
  Vec3F heart_middle = Vec3F::Zero();                  ///< see DrawnHeart::middle
  float heart_reach = 0;                               ///< [mm] about it, also where there is none

  /// Tissue::Outside where the heart and its fat are not. @param lps in the patient
  [[nodiscard]] Tissue heart_at(const Vec3F& lps, const DrawnHeart::Moment& moment) const;
};

/// [pixel] of slice k, 1 where the heart or its fat may be at some time of the beat, as far as
/// places 4 pixels apart can tell, with a margin of as much: nowhere else need one look.
/// @param half_mm how far before and behind the slice one will look
[[nodiscard]] std::vector<std::uint8_t> near_heart(const DrawnScene& scene, const DrawnStack& stack,
                                                   int k, const Eigen::Vector2f& shift,
                                                   float half_mm);

}  // namespace beatlas::phantom
