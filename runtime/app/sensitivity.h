#pragma once
/// What each constant of paper B's trainer does: the natural beat and a finger 8 mm deep, with the
/// constant as it is, at half and at twice.

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/palpation/parameters.h"

namespace beatlas::app {

/// Of a ventricle with one set of parameters, settled.
struct SensitivityFigures {
  palpation::Beat natural;  ///< without a finger
  palpation::Beat pressed;
  double mean_n = 0;      ///< of the finger's force, over a beat
  double largest_n = 0;   ///< in it
  double diastole_n = 0;  ///< at its end-diastole
};

/// A constant and what became of it; the finger stands below the wall of the heart's own
/// end-diastole, wherever that then lies.
struct SensitivityRow {
  std::string symbol;   ///< as paper B prints it
  std::string meaning;  ///< in words, with the unit
  double value = 0;     ///< as it is
  double low = 0;       ///< half of it, or the nearest that is in range
  double high = 0;      ///< twice it, or the nearest that is in range
  SensitivityFigures at_low;
  SensitivityFigures at_high;
};

struct Sensitivity {
  double depth_mm = 8;
  SensitivityFigures as_it_is;
  std::vector<SensitivityRow> rows;
};

/// Table 1's rows (base, middle and apex together), the symbols of equations (5) and (6),
/// pressures, heart rate and weight of `parameters`. S_n stands for V_e, L_0 and T_s, of which
/// equation (5) makes it. @throws Error{InvalidInput} if a parameter is out of range
[[nodiscard]] Sensitivity sensitivity_of(const palpation::PalpationParameters& parameters);

/// See schemas/sensitivity.schema.json.
[[nodiscard]] nlohmann::json sensitivity_json(const Sensitivity& sensitivity);
/// A table of changes in per cent, at half / at twice.
[[nodiscard]] std::string sensitivity_markdown(const Sensitivity& sensitivity);
/// sensitivity.json and sensitivity.md; makes the folder. @throws Error{Machine}
void write_sensitivity(const Sensitivity& sensitivity, const std::filesystem::path& folder);

}  // namespace beatlas::app
