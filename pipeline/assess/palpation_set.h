#pragma once
/// Paths of a finger on a beating heart, for measuring what it would feel.

#include <cstddef>
#include <vector>

#include "pipeline/phantom/phantom.h"

namespace beatlas::assess {

/// The finger moves as a user's does: at most 8 mm deep, 1 to 3 Hz (reference numbers, section 4).
struct PalpationOptions {
  Structure structure = Structure::Heart;
  int places = 32;       ///< 1..1000 on the surface, each felt in three ways
  double depth_mm = 8;   ///< 0..15: of a press, below the surface at end diastole (t = 0)
  double finger_mm = 8;  ///< > 0: radius of the finger that must reach a place
  double crease_mm = 6;  ///< >= 0: a place keeps this far from creases of the surface at t = 0
  int cycles = 2;        ///< 1..20 beats
};

enum class Touch {
  Press,  ///< in and out along the inward normal, a sine of 1, 2 or 3 Hz from place to place
  Hold,   ///< still at 1/4, 1/2 or 3/4 of the depth while the heart beats: the dynamic step
  Slide,  ///< at 3/8 of the depth, 10 mm to and fro across the normal at 1 Hz
};

struct Trajectory {
  Touch touch{};
  std::vector<Vec3> at_lps;  ///< [tick] patient LPS [mm]
};

struct PalpationSet {
  Structure structure{};
  int ticks_per_beat = 0;  ///< the whole number nearest to 1000 a second
  double tick_s = 0;       ///< R-R interval / ticks_per_beat
  std::vector<Trajectory> trajectories;
};

/// Places are spread as far from each other as the surface allows, each the farthest from those
/// before it, where a ball of the finger's radius touches no other part of the surface. The same
/// set whatever the machine.
/// @throws Error{InvalidInput} if an option is out of range or the finger reaches no place.
[[nodiscard]] PalpationSet palpation_set(const phantom::Phantom& phantom,
                                         const PalpationOptions& options);

}  // namespace beatlas::assess
