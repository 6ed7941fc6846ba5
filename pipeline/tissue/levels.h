#pragma once
#include <limits>

namespace beatlas::tissue {

/// Intensities that part the tissues.
struct TissueLevels {
  double blood = 0;      ///< typical blood
  double rv_blood = 0;   ///< the right ventricle's blood: coils light it differently
  double muscle = 0;     ///< typical muscle; 0 = not known yet
  double threshold = 0;  ///< between muscle and blood
  double dark = 0;       ///< below it: lung, air

  /// Sets what lies between, from blood and muscle.
  void part() {
    threshold = 0.5 * (blood + muscle);
    dark = 0.5 * muscle;
  }
};

}  // namespace beatlas::tissue
