#include "pipeline/alarm/leak_seed.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace beatlas::alarm {
namespace {

constexpr double kAroundMm = 8;    ///< labels so near tell which way is inside
constexpr double kStepMm = 0.5;    ///< of the way in
constexpr double kDeepestMm = 40;  ///< of it
constexpr double kSkinMm = 4;      ///< a surface lies within so much of its labels
/// What may lie under the heart's surface without a leak: the RV's wall and fat, and the LV's
/// muscle at end-systole (11 to 16 mm where it is healthy).
constexpr double kRestMm = 5;
constexpr double kMuscleMm = 16;
constexpr double kLeastLeakMm = 4;
constexpr double kLeastRadiusMm = 2;
constexpr double kMostRadiusMm = 6;
constexpr double kJumpRadiusMm = 4;
constexpr double kAirMm = 3;  ///< inside, where a surface holds what is dark

std::optional<std::uint8_t> label_at(const LabelCycle& labels, int phase, const Vec3& index) {
  std::array<int, 3> at{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double place = index[static_cast<int>(axis)];
    if (!(place > -0.5 && place < labels.grid.size[axis] - 0.5)) return std::nullopt;
    at[axis] = static_cast<int>(std::lround(place));
  }
  return labels.phases[static_cast<std::size_t>(phase)][labels.grid.offset(at[0], at[1], at[2])];
}

/// Unit vector in the slice, along the grid's axes [mm], towards where labels are; zero if none.
Vec3 way_in(const LabelCycle& labels, int phase, const Vec3& index) {
  const Vec3 spacing = labels.grid.spacing_mm();
  Vec3 sum = Vec3::Zero();
  const int reach = static_cast<int>(std::ceil(kAroundMm / spacing.head<2>().minCoeff()));
  for (int dj = -reach; dj <= reach; ++dj) {
    for (int di = -reach; di <= reach; ++di) {
      const Vec3 away = Vec3(di, dj, 0).cwiseProduct(spacing);
      if (away.norm() > kAroundMm) continue;
      const auto label = label_at(labels, phase, index + Vec3(di, dj, 0));
      if (!label) continue;
      sum += *label == kLabelBackground ? Vec3(-away) : away;
    }
  }
  return sum.norm() > 0 ? Vec3(sum.normalized()) : Vec3(Vec3::Zero());
}

/// To what a command says: what is tried is what a person then runs.
double in_tenths(double mm) { return std::round(mm * 10) / 10; }

LeakSeed seed_at(std::uint8_t label, const Vec3& lps_mm, double radius_mm, int phase) {
  return {label, lps_mm.unaryExpr(&in_tenths), in_tenths(radius_mm), phase};
}

}  // namespace

std::optional<LeakSeed> seed_under(const LeakAlarm& alarm, const Vec3& lps_mm,
                                   const LabelCycle& labels) {
  if (alarm.structure != Structure::Heart) return std::nullopt;
  const Vec3 surface = labels.grid.mm_from_index.inverse() * lps_mm;
  const Vec3 in_mm = way_in(labels, alarm.phase, surface);
  const Vec3 in = in_mm.cwiseQuotient(labels.grid.spacing_mm());
  if (in.isZero()) return std::nullopt;
  // The run of one label under the surface.
  double from = 0;
  std::uint8_t first = kLabelBackground;
  for (; from <= kSkinMm; from += kStepMm) {
    first = label_at(labels, alarm.phase, surface + from * in).value_or(kLabelBackground);
    if (first != kLabelBackground) break;
  }
  const bool muscle = first == kLabelLvMyocardium;
  if (!muscle && first != kLabelRestOfHeart) return std::nullopt;
  double to = from;
  while (to < kDeepestMm && label_at(labels, alarm.phase, surface + (to + kStepMm) * in) == first) {
    to += kStepMm;
  }
  const bool air = alarm.kind == LeakKind::Air;
  double leak_mm = air ? 2 * kAirMm : to - from - (muscle ? kMuscleMm : kRestMm);
  // Where nothing else lies so deep, as in a heart without chambers, the leak's own end is not
  // told.
  if (to >= kDeepestMm) leak_mm = std::min(leak_mm, 2 * kMostRadiusMm);
  if (leak_mm < kLeastLeakMm) return std::nullopt;
  const Vec3 middle = surface + (from + leak_mm / 2) * in;
  LeakSeed out = seed_at(kLabelBackground, labels.grid.mm_from_index * middle,
                         std::clamp(leak_mm / 2, kLeastRadiusMm, kMostRadiusMm), -1);
  for (int phase = 0; phase < labels.phase_count(); ++phase) {
    const std::uint8_t there = label_at(labels, phase, middle).value_or(kLabelBackground);
    if (there != first && there != kLabelBackground) out.phase = alarm.phase;
  }
  return out;
}

std::optional<LeakSeed> seed_beside(const LeakAlarm& alarm, const LabelCycle& labels, int before,
                                    int after) {
  const Vec3 index = labels.grid.mm_from_index.inverse() * alarm.lps_mm;
  // No seed tells an atrium or a vessel from the rest of the heart.
  const auto at = [&](int phase) -> std::optional<std::uint8_t> {
    const auto label = label_at(labels, phase, index);
    return label ? std::optional(ventricles_apart(*label)) : std::nullopt;
  };
  const auto then = at(before);
  if (!then || then != at(after) || then == at(alarm.phase)) return std::nullopt;
  return seed_at(*then, alarm.lps_mm, kJumpRadiusMm, alarm.phase);
}

}  // namespace beatlas::alarm
