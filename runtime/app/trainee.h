#pragma once
/// Trainees that need no hand: they palpate an atlas by a plan, feel with a stated error, and mark
/// what they believe is ill. What an exercise's score tells apart is tested with them.

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/app/exercise_ground.h"
#include "runtime/device/device.h"
#include "runtime/device/pacer.h"
#include "runtime/exercise/exercise.h"

namespace beatlas::app {

struct Skill {
  double weber = 0.07;     ///< standard deviation of a felt force, as a share of it
  double spacing_mm = 10;  ///< between the places that it palpates, spread over the touchable wall
  int most_places = 150;   ///< that it has the patience for
  int second_looks = 5;    ///< at the places that struck most, before it decides
  bool knows_normal = true;  ///< compares with a healthy wall at that place, not with other places
  bool knows_names = true;   ///< tells kinds apart by diastole and systole; otherwise guesses
};
/// skilled: 7 % (Pang et al. 1991), the whole wall. unskilled: 30 %, six places.
/// @throws Error{Usage} naming the skills there are
[[nodiscard]] Skill skill_from_name(const std::string& name);

/// A finger that goes from place to place, presses each 4 mm deep over a beat and a half with the
/// moving wall, notes the force at end-diastole and end-systole, returns to where they deviate
/// most, and presses the button of what it takes that for.
class Trainee final : public device::Device {
 public:
  struct Options {
    Skill skill;
    std::vector<std::uint32_t> places;  ///< vertices to choose from; empty: of its own choice
    double heart_rate_per_min = 0;      ///< 0: the atlas's own
    std::uint64_t seed = 0;
    device::Pace pace = device::Pace::Fast;
  };
  /// @param atlas, asked must outlive it
  Trainee(const ExerciseGround& atlas, const exercise::Exercise& asked, Options options);
  ~Trainee() override;

  [[nodiscard]] std::string name() const override { return "trainee"; }
  device::RunReport run(const device::ServoFn& servo, std::stop_token stop) override;

 private:
  class Hand;
  const ExerciseGround& atlas_;
  const exercise::Exercise& asked_;
  Options options_;
};

}  // namespace beatlas::app
