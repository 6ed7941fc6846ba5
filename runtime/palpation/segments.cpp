#include "runtime/palpation/segments.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace beatlas::palpation {
namespace {

constexpr double kApexBelow = 0.08;
constexpr double kJnd = 0.07;
constexpr double kLeastForceN = 0.049;

constexpr std::array<std::string_view, kSegments> kNames{"basal_anterior",
                                                         "basal_anteroseptal",
                                                         "basal_inferoseptal",
                                                         "basal_inferior",
                                                         "basal_inferolateral",
                                                         "basal_anterolateral",
                                                         "mid_anterior",
                                                         "mid_anteroseptal",
                                                         "mid_inferoseptal",
                                                         "mid_inferior",
                                                         "mid_inferolateral",
                                                         "mid_anterolateral",
                                                         "apical_anterior",
                                                         "apical_septal",
                                                         "apical_inferior",
                                                         "apical_lateral",
                                                         "apex"};

}  // namespace

std::string_view segment_name(int segment) noexcept {
  return kNames[static_cast<std::size_t>(segment - 1)];
}

std::string segment_names() {
  std::string names;
  for (const std::string_view name : kNames) {
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return names;
}

std::optional<int> segment_from_name(std::string_view name) noexcept {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<int>(found - kNames.begin()) + 1;
}

double segment_share(int segment) noexcept { return segment <= 12 ? 0.35 / 6 : 0.30 / 5; }

int segment_at(double long_axis, double angle_rad) noexcept {
  if (long_axis < kApexBelow) return kSegments;
  const double turns = angle_rad / (2 * std::numbers::pi);
  const double turn = turns - std::floor(turns);
  const auto sector = [turn](int count) {  // the first is centred at 0
    return static_cast<int>(std::floor(turn * count + 0.5)) % count;
  };
  if (long_axis < 1.0 / 3) return 13 + sector(4);
  return (long_axis < 2.0 / 3 ? 7 : 1) + sector(6);
}

BullsEyeSector bulls_eye_sector(int segment) noexcept {
  constexpr double kTurn = 2 * std::numbers::pi;
  constexpr double kAbove = kTurn / 4;
  if (segment == 17) return {0, 0.25, 0, kTurn};
  const int ring = segment <= 6 ? 2 : segment <= 12 ? 1 : 0;
  const int count = ring == 0 ? 4 : 6;
  const int first = ring == 2 ? 1 : ring == 1 ? 7 : 13;
  const double width = kTurn / count;
  const double middle = kAbove + width * (segment - first);  // to the left, where the septum is
  return {0.25 * (ring + 1), 0.25 * (ring + 2), middle - width / 2, middle + width / 2};
}

std::array<double, 2> bulls_eye_place(double long_axis, double angle_rad) noexcept {
  // Rings of one width, as their sectors: straight between the ends of apex and thirds.
  constexpr std::array kEnds{0.0, kApexBelow, 1.0 / 3, 2.0 / 3, 1.0};
  const double along = std::clamp(long_axis, 0.0, 1.0);
  std::size_t ring = 0;
  while (ring + 2 < kEnds.size() && along > kEnds[ring + 1]) ++ring;
  const double within = (along - kEnds[ring]) / (kEnds[ring + 1] - kEnds[ring]);
  const double radius = 0.25 * (static_cast<double>(ring) + within);
  return {-radius * std::sin(angle_rad), radius * std::cos(angle_rad)};
}

double alpha_of_thickening(double thickening) noexcept {
  constexpr double kHealthyThickening = 0.57;
  return std::clamp(thickening / kHealthyThickening, 0.0, 1.0);
}

Infarct infarct_of(const SegmentTissue& tissue) noexcept {
  Infarct out;
  for (int segment = 1; segment <= kSegments; ++segment) {
    const double alpha = tissue[static_cast<std::size_t>(segment - 1)].alpha;
    if (!(alpha < 1)) continue;
    out.fraction += segment_share(segment);
    out.alpha += segment_share(segment) * alpha;
  }
  if (out.fraction > 0) out.alpha /= out.fraction;
  out.fraction = std::min(out.fraction, 1.0);  // seventeen shares add up to 1 but for rounding
  return out;
}

double force_jnds(double force_n, double reference_n) noexcept {
  return std::abs(force_n - reference_n) / std::max(kJnd * std::abs(reference_n), kLeastForceN);
}

}  // namespace beatlas::palpation
