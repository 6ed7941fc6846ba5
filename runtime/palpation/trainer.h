#pragma once
/// Paper B's trainer in one tick: fingers, the wall under them, the circulation behind it.
///
/// The wall moves by equation (1): the ventricle is a cylinder of side S0 less the fingers' dents,
///   V = V_ref + S0 x_wall - S_c sum A_i,
/// so a finger D below the wall of end-diastole is d = D + x_wall below the wall of now. Each
/// finger feels its patch at that depth (patch.h), of stiffness K_v + K_e(t) (equation 6) + pi p R
/// (what the filling pressure adds, muscle.h), less what the dents of the others already give way
/// (dent.h). The circulation is pushed by the one dent as large as all of them together. So with
/// two fingers or more the wall's motion in systole is approximate: in truth each finger would stop
/// the wall at its own depth, here one stop of their mean depth does.
///
/// Two threads, as haptics::Servo: the servo's calls `tick` alone, which neither allocates, locks
/// nor throws; the caller's may wish for other parameters and look at what was published.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "runtime/base/geometry.h"
#include "runtime/haptics/hand_over.h"
#include "runtime/haptics/seqlock.h"
#include "runtime/palpation/circulation.h"
#include "runtime/palpation/dent.h"
#include "runtime/palpation/parameters.h"
#include "runtime/palpation/patch.h"

namespace beatlas::palpation {

struct Finger {
  Vec3 place_mm = Vec3::Zero();  ///< on the surface; tells fingers apart, any frame
  double depth_m = -1;     ///< D: below the wall as it lies at end-diastole, held within -1..0.03;
                           ///< below 0: above it
  double long_axis = 0.5;  ///< 0 apex .. 1 base
  int segment = 0;         ///< 1..17; 0: healthy
  /// Of the place itself, where an atlas tells it (regions.h); none: the segment's
  std::optional<Tissue> tissue = std::nullopt;
};

/// One tick as a whole; trivially copyable.
struct Signals {
  double time_s = 0;
  double phase = 0;  ///< of the beat, 0..1, 0 at end-diastole
  double heart_rate_per_min = 0;
  double volume_ml = 0;
  double lv_mmhg = 0;
  double aortic_mmhg = 0;
  double left_atrial_mmhg = 0;
  double mitral_flow_ml_s = 0;
  double aortic_flow_ml_s = 0;
  double elastance_mmhg_per_ml = 0;
  double wall_m = 0;                    ///< x_wall, outward
  Beat beat;                            ///< the last one that ended
  double natural_output_l_per_min = 0;  ///< without fingers, with the parameters first given
  std::uint64_t beats = 0;
  std::uint64_t ticks = 0;
  std::uint32_t fingers = 0;
  std::array<double, kMostFingers> force_n{};
  std::array<double, kMostFingers> muscle_n{};  ///< of the horizontal muscle there, equation (3)
  std::array<double, kMostFingers> depth_m{};   ///< d
  std::array<double, kMostFingers> dent_m{};    ///< of the surface at the finger, for the picture
  /// By which the dents of the other fingers have the wall give way there.
  std::array<double, kMostFingers> given_m{};
};

class Trainer {
 public:
  /// Settles the natural beat first (some milliseconds). @param fingers 1..kMostFingers
  /// @throws Error{InvalidInput} if a parameter is out of range.
  Trainer(const PalpationParameters& parameters, std::size_t fingers);
  ~Trainer() = default;
  Trainer(const Trainer&) = delete;
  Trainer& operator=(const Trainer&) = delete;

  /// @param fingers as many as were told; missing ones are above the wall, further ones left out
  /// @return the force on each finger along the outward normal [N]; valid until the next tick
  std::span<const double> tick(double step_s, std::span<const Finger> fingers) noexcept;

  // The caller's thread.
  /// Everything may change while running: numbers glide there in a quarter of a second, the heart
  /// rate at the next beat. Neither waits for the servo nor makes it wait.
  /// @throws Error{InvalidInput} if a parameter is out of range.
  void wish(const PalpationParameters& parameters);
  [[nodiscard]] Signals published() const noexcept { return published_.read(); }
  /// The same for a thread that must not wait: false where it is being written.
  [[nodiscard]] bool latest(Signals& signals) const noexcept {
    return published_.try_read(signals);
  }

  // The servo's thread, or none.
  [[nodiscard]] const Circulation& circulation() const noexcept { return circulation_; }
  [[nodiscard]] const Signals& signals() const noexcept { return signals_; }

 private:
  struct Touch {
    VerticalPatch patch;
    HorizontalMuscle horizontal;
    MuscleConstants muscle;
    double alpha = 1;
    double long_axis = -1;
    int segment = -1;
    std::optional<Tissue> tissue = std::nullopt;
    Vec3 place_mm = Vec3::Zero();
  };

  void take_up_wish() noexcept;
  void glide(double step_s) noexcept;
  void hold_aortic_pressure() noexcept;
  void place(Touch& touch, const Finger& finger) noexcept;
  [[nodiscard]] double wall_m(double whole_dent_m) const noexcept;

  PalpationParameters parameters_;  // wished, as of now
  CirculationParameters target_;
  bool gliding_ = false;
  double resistance_factor_ = 1;  // by which an aortic target is held
  Circulation circulation_;
  double side_area_cm2_ = 0;
  DentField dents_;
  std::array<std::unique_ptr<Touch>, kMostFingers> touches_;
  std::size_t count_;
  std::array<double, kMostFingers> forces_{};
  Signals signals_;
  haptics::Seqlock<Signals> published_;
  haptics::HandOver<PalpationParameters> wishes_;
  std::unique_ptr<PalpationParameters> wished_;  // the last wish that was taken up
};

}  // namespace beatlas::palpation
