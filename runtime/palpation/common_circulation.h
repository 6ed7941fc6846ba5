#pragma once
/// One circulation behind all the fingers on a heart, each of which has a thread and a servo of its
/// own: what one displaces, the others feel as pressure and as motion of the wall.
///
/// The images show how the wall moves without a finger, so where a finger is D m below the wall of
/// end-diastole, they show it d = D + x_natural deep, x_natural the wall's motion of the natural
/// beat (equation 1). With fingers the wall moves by x instead: the finger is x - x_natural deeper.

#include <array>
#include <atomic>
#include <cstddef>

#include "runtime/base/geometry.h"
#include "runtime/haptics/seqlock.h"
#include "runtime/palpation/trainer.h"

namespace beatlas::palpation {

/// Nobody waits for anybody: whichever finger comes first takes the circulation on, the others pass
/// by, and what is being written is read at the next tick.
class CommonCirculation {
 public:
  /// What a finger feels of the circulation and of the other fingers.
  struct Felt {
    double pressure_n_per_m = 0;  ///< pi p R
    double wall_m = 0;            ///< x - x_natural, outward
    double given_m = 0;           ///< by which the others' dents have the wall give way here
    /// S_n of equation (5), of the last beat over the natural one's: K_e by equation (6) goes with
    /// it.
    double shortening_ratio = 1;
  };

  /// Settles the natural beat: some milliseconds. @param parameters of this heart
  /// @param end_diastole phase of the heart's cycle at which contraction begins
  /// @param fingers 1..kMostFingers  @throws Error{InvalidInput} as Trainer
  CommonCirculation(const PalpationParameters& parameters, double end_diastole,
                    std::size_t fingers);

  // The finger's own thread; `finger` below the number that was told.
  /// @param place_mm on the surface  @param depth_m d, below the surface of the images; negative:
  /// above  @param phase of the heart's cycle, 0..1; of the first finger that is not lifted it is
  /// the circulation's
  void tell(std::size_t finger, const Vec3& place_mm, double depth_m, double phase) noexcept;
  /// It touches nothing any more, and its heart no longer leads.
  void lift(std::size_t finger) noexcept;
  [[nodiscard]] Felt felt(std::size_t finger) noexcept;

  // Any finger's thread.
  /// Goes on to the phase that leads, unless another thread is doing so. A beat is as long
  /// as the heart takes for it; what the circulation lags behind by is made up for little by
  /// little.
  void advance() noexcept;
  /// The newest tick as a whole; false where one is being written: `signals` stays as it was.
  [[nodiscard]] bool latest(Signals& signals) const noexcept;

  // Another thread.
  /// As Trainer::wish. @throws Error{InvalidInput} if a parameter is out of range
  void wish(const PalpationParameters& parameters);
  [[nodiscard]] Signals published() const noexcept { return trainer_.published(); }

 private:
  struct Told {
    std::array<double, 3> place_mm{};
    double depth_m = -1;
    double phase = -1;  ///< below 0: lifted
  };
  struct Answer {
    double pressure_n_per_m = 0;
    double wall_m = 0;
    double shortening_ratio = 1;
    std::array<double, kMostFingers> given_m{};
  };
  void advance_to(double phase) noexcept;
  void answer() noexcept;

  Trainer trainer_;
  Trainer natural_;
  double end_diastole_;
  std::size_t count_;
  std::array<haptics::Seqlock<Told>, kMostFingers> told_;
  std::array<Told, kMostFingers> heard_{};  ///< of whoever takes the circulation on
  haptics::Seqlock<Answer> answer_;
  std::array<Answer, kMostFingers> read_{};  ///< of each finger's own thread
  double last_phase_ = -1;
  std::atomic_flag advancing_;
};

}  // namespace beatlas::palpation
