#include "runtime/exercise/findings.h"

#include <algorithm>

#include "runtime/palpation/units.h"

namespace beatlas::exercise {

double harmful_force_n(double diastolic_mmhg, double finger_area_cm2) noexcept {
  return diastolic_mmhg * palpation::kPaPerMmhg * finger_area_cm2 * palpation::kM2PerCm2;
}

double felt_radius_mm(double tool_radius_mm) noexcept {
  // Of a fingertip that touches some 1 cm^2 with little force.
  constexpr double kFingertipMm = 5;
  return std::max(tool_radius_mm, kFingertipMm);
}

Examination::Examination(const Exercise& exercise, const Ground& ground, double harmful_n)
    : exercise_(exercise),
      ground_(ground),
      harmful_n_(harmful_n),
      felt_mm_(felt_radius_mm(exercise.tool_radius_mm)),
      contact_s_(ground.wall.vertex_count(), 0) {}

void Examination::add(const FeltTick& tick) {
  const double elapsed_s = has_last_ ? std::max(0.0, tick.time_s - last_.time_s) : 0;
  feel(tick, elapsed_s);
  const std::uint32_t pressed = tick.buttons & ~(has_last_ ? last_.buttons : tick.buttons);
  for (std::size_t n = 0; n < exercise_.kinds.size(); ++n) {
    if ((pressed >> n & 1U) == 0 || !has_touched_) continue;
    found_.marks.push_back(
        {.time_s = found_.palpation.time_s,
         .named = exercise_.kinds[n],
         .place = ground_.wall.material_at(touched_.contact_mm, touched_.beats)});
  }
  last_ = tick;
  has_last_ = true;
}

void Examination::feel(const FeltTick& tick, double elapsed_s) {
  Palpation& p = found_.palpation;
  p.time_s += elapsed_s;
  p.peak_n = std::max(p.peak_n, tick.force_n);
  if (tick.force_n > harmful_n_) p.harmful_s += elapsed_s;
  if (!tick.touching) return;
  if (has_last_ && last_.touching) p.path_mm += (tick.tool_mm - last_.tool_mm).norm();
  p.contact_s += elapsed_s;
  force_sum_ns_ += tick.force_n * elapsed_s;
  touched_ = tick;
  has_touched_ = true;
  const palpation::WallPlace place = ground_.wall.follow(tick.contact_mm, tick.beats, trail_);
  if (ground_.touchable[place.vertex]) contact_s_[place.vertex] += static_cast<float>(elapsed_s);
}

void Examination::end_part() noexcept {
  has_last_ = false;
  has_touched_ = false;
}

Findings Examination::findings() const {
  Findings out = found_;
  if (out.palpation.contact_s > 0) out.palpation.mean_n = force_sum_ns_ / out.palpation.contact_s;
  const palpation::LvWall& wall = ground_.wall;
  out.under_finger_s.assign(wall.vertex_count(), 0);
  double touchable = 0;
  double felt = 0;
  for (std::uint32_t v = 0; v < wall.vertex_count(); ++v) {
    if (!ground_.touchable[v]) continue;
    for (std::uint32_t u = 0; u < wall.vertex_count(); ++u) {
      if (contact_s_[u] > 0 && (wall.mm(u) - wall.mm(v)).norm() <= felt_mm_) {
        out.under_finger_s[v] += contact_s_[u];
      }
    }
    const double area = wall.muscle_share()[v] / static_cast<double>(wall.wall_mm()[v]);
    touchable += area;
    felt += out.under_finger_s[v] > 0 ? area : 0;
  }
  if (touchable > 0) out.palpation.share = felt / touchable;
  return out;
}

}  // namespace beatlas::exercise
