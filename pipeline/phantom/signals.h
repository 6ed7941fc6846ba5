#pragma once
#include <string>
#include <vector>

namespace beatlas::phantom {

/// bSSFP signal, blood = 1; by default preset B. Section 6 of the reference numbers.
struct Signals {
  double blood = 1.0;
  double myocardium = 0.34;
  double fat = 1.29;
  double liver = 0.55;
  double muscle = 0.28;
  double lung = 0.04;
  double bone = 0.12;
  double air = 0.0;
};

/// - "A": low contrast, myocardium 0.60, fat 0.75, liver 0.75, bone 0.12;
/// - "B": literature-like T1 and T2, as in Signals.
/// What a preset's numbers leave out is as in the other.
/// @throws Error{InvalidInput} naming the presets.
[[nodiscard]] Signals signals_preset(const std::string& name);
[[nodiscard]] std::vector<std::string> signals_names();

}  // namespace beatlas::phantom
