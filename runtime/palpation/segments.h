#pragma once
/// The 17 segments of the left ventricle (Cerqueira et al., AHA 2002), and what a finger tells
/// apart.

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/palpation/muscle.h"

namespace beatlas::palpation {

inline constexpr int kSegments = 17;

/// 1 basal_anterior .. 17 apex. @pre 1 <= segment <= 17
[[nodiscard]] std::string_view segment_name(int segment) noexcept;
/// All of them, for a message: "basal_anterior, ..., apex".
[[nodiscard]] std::string segment_names();
[[nodiscard]] std::optional<int> segment_from_name(std::string_view name) noexcept;

/// Share of the ventricle's muscle: 35 % basal, 35 % mid, 30 % apical with the apex.
/// @pre 1 <= segment <= 17
[[nodiscard]] double segment_share(int segment) noexcept;

/// @param long_axis 0 apex .. 1 base, thirds: basal, mid, apical; the lowest 0.08 is the apex
/// @param angle_rad around the long axis, 0 in the middle of the anterior wall, turning towards the
/// septum; any number
[[nodiscard]] int segment_at(double long_axis, double angle_rad) noexcept;

/// The bull's eye of the AHA: a segment's place in a disc of radius 1, the anterior wall above.
/// Rings from the middle: apex, apical, mid, basal; the septum lies to the left, as it is seen from
/// the apex.
struct BullsEyeSector {
  double inner = 0;
  double outer = 1;
  double begin_rad = 0;  ///< counter-clockwise from the right
  double end_rad = 0;
};
/// @pre 1 <= segment <= 17
[[nodiscard]] BullsEyeSector bulls_eye_sector(int segment) noexcept;
/// A place of the wall in that disc, x to the right, y up. @param long_axis, angle_rad as
/// segment_at
[[nodiscard]] std::array<double, 2> bulls_eye_place(double long_axis, double angle_rad) noexcept;

/// Without an image of scar: alpha by how much the wall thickens in systole, as a share of its
/// diastolic thickness; 57 % is a healthy wall's. 0..1.
[[nodiscard]] double alpha_of_thickening(double thickening) noexcept;

using SegmentTissue = std::array<Tissue, kSegments>;  ///< [segment - 1]

/// Infarct of the whole ventricle: f, the share of muscle that does not contract fully, and the
/// mean of alpha in it.
struct Infarct {
  double fraction = 0;
  double alpha = 0;
};
[[nodiscard]] Infarct infarct_of(const SegmentTissue& tissue) noexcept;

/// Difference of two forces in steps that a finger can just tell apart: 7 % of the reference (Pang
/// et al. 1991), but no less than paper B's smallest force, 5 gf.
[[nodiscard]] double force_jnds(double force_n, double reference_n) noexcept;

}  // namespace beatlas::palpation
