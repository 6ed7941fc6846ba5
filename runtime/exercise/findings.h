#pragma once
/// What a trainee did: marks, and how the wall was palpated.

#include <cstdint>
#include <vector>

#include "runtime/exercise/lesion.h"

namespace beatlas::exercise {

/// One tick of a trial, as its servo saw it.
struct FeltTick {
  double time_s = 0;
  double beats = 0;                ///< of the heart, since its cycle began
  Vec3 tool_mm = Vec3::Zero();     ///< the finger's middle
  Vec3 contact_mm = Vec3::Zero();  ///< on the heart's surface
  bool touching = false;
  double force_n = 0;         ///< sent to the device
  std::uint32_t buttons = 0;  ///< bit n: button n is down
};

/// Button n was pressed: here is kinds[n].
struct Mark {
  double time_s = 0;
  LesionKind named = LesionKind::Soft;
  palpation::LvWall::Material place;
};

struct Palpation {
  double time_s = 0;     ///< of the trial
  double contact_s = 0;  ///< of it in contact
  double path_mm = 0;    ///< of the finger, in contact
  double share = 0;      ///< 0..1: of the touchable wall that was under the finger
  double peak_n = 0;
  double mean_n = 0;     ///< in contact
  double harmful_s = 0;  ///< above the harmful force
};

struct Findings {
  std::vector<Mark> marks;
  Palpation palpation;
  std::vector<float> under_finger_s;  ///< [vertex]
};

/// [N] that shuts small vessels under a finger, which blood at diastolic pressure no longer opens:
/// that pressure over what the fingertip touches, Contractile::finger_area_cm2.
/// @param diastolic_mmhg of the aorta
[[nodiscard]] double harmful_force_n(double diastolic_mmhg, double finger_area_cm2) noexcept;

/// How far about the place of contact the muscle counts as felt [mm]: the tool's radius, at least
/// that of a fingertip's contact.
[[nodiscard]] double felt_radius_mm(double tool_radius_mm) noexcept;

/// Gathers a trial tick by tick. A mark is of the place that was last touched; one without any is
/// none. Not for a servo's tick: it searches the wall.
class Examination {
 public:
  Examination(const Exercise& exercise, const Ground& ground, double harmful_n);

  void add(const FeltTick& tick);
  /// A part of the trial ends: the next tick's time begins anew.
  void end_part() noexcept;
  [[nodiscard]] Findings findings() const;

 private:
  void feel(const FeltTick& tick, double elapsed_s);

  const Exercise& exercise_;
  const Ground& ground_;
  double harmful_n_;
  double felt_mm_;
  Findings found_;
  palpation::LvWall::Trail trail_;
  std::vector<float> contact_s_;  ///< [vertex] it was nearest to the place of contact
  double force_sum_ns_ = 0;
  FeltTick last_;
  bool has_last_ = false;
  FeltTick touched_;
  bool has_touched_ = false;
};

}  // namespace beatlas::exercise
