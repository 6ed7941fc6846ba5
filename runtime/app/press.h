#pragma once
/// Paper B's experiment without a device: a finger is pressed onto the beating ventricle, held and
/// let go, along a scripted path.

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/palpation/parameters.h"

namespace beatlas::app {

inline constexpr double kTickS = 1e-3;  ///< of a scripted press

/// Natural beats, then the finger goes in on half a cosine, stays, and comes out the same way.
struct PressScript {
  double depth_mm = 8;     ///< 0..10, below the wall of end-diastole
  double natural_s = 2;    ///< before it; at least two beats and a half
  double moving_s = 0.25;  ///< in, and out
  double held_s = 12;      ///< long enough for the circulation to settle; longer below 60 a minute
  double after_s = 2;
  double long_axis = 0.5;  ///< 0 apex .. 1 base
  int segment = 7;         ///< mid anterior
};

struct PressRow {
  double time_s;
  double displacement_mm;  ///< D of the finger; 0 at the wall of end-diastole
  double depth_mm;         ///< below the moving wall
  double dent_mm;
  double force_n;
  double volume_ml;
  double lv_mmhg;
  double aortic_mmhg;
  double mitral_ml_s;
  double aortic_ml_s;
  double output_l_per_min;  ///< of the last beat
};

struct Press {
  PressScript script;             ///< as it was run
  std::vector<PressRow> rows;     ///< one a millisecond
  std::vector<PressRow> natural;  ///< one beat, from end-diastole to end-diastole
  std::vector<PressRow> pressed;  ///< the last whole beat before the finger is let go
  palpation::Beat natural_beat;
  palpation::Beat pressed_beat;
};

/// A beat of what a finger feels, and how far that is from healthy muscle in steps that can just be
/// told apart.
struct FeltBeat {
  std::vector<double> time_s;  ///< from end-diastole
  std::vector<double> force_n;
  double diastole_n = 0;  ///< at end-diastole
  double systole_n = 0;   ///< where the contraction is strongest
  double diastole_jnd = 0;
  double systole_jnd = 0;
};

struct TissueForce {
  std::string name;
  FeltBeat in_space;   ///< the finger stands where the script holds it; the wall comes and goes
  FeltBeat with_wall;  ///< it goes with the wall, half as deep: the muscle itself
};

/// D of the finger [mm] at t [s].
[[nodiscard]] double finger_displacement_mm(const PressScript& script, double t);

/// @throws Error{InvalidInput} if script or parameters are out of range.
[[nodiscard]] Press run_press(const palpation::PalpationParameters& parameters,
                              const PressScript& script);

/// The same press on healthy muscle and on each disease's preset, and beside an infarct.
[[nodiscard]] std::vector<TissueForce> compare_tissues(const PressScript& script);

/// press.csv, press.svg (paper B's figure 8), loops.csv, loops.svg (figure 7b), tissues.csv,
/// tissues.svg; makes the folder. @throws Error{Machine} if one cannot be written.
void write_press(const Press& press, const std::vector<TissueForce>& tissues,
                 const std::filesystem::path& folder);

/// See schemas/press.schema.json.
[[nodiscard]] nlohmann::json press_json(const Press& press,
                                        const std::vector<TissueForce>& tissues);
/// What of `tissues` is told; its jnd are set against the first.
[[nodiscard]] nlohmann::json tissues_json(const std::vector<TissueForce>& tissues);
void compare_with_first(std::vector<TissueForce>& tissues);
/// A few lines for people; ends with a newline.
[[nodiscard]] std::string press_text(const Press& press, const std::vector<TissueForce>& tissues);

}  // namespace beatlas::app
