#pragma once
/// All that the palpation trainer can be told, its presets, and its JSON.

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/palpation/circulation.h"
#include "runtime/palpation/muscle.h"
#include "runtime/palpation/segments.h"

namespace beatlas::palpation {

struct PalpationParameters {
  MuscleTable muscle;             ///< Table 1
  double wall_mass_kg = 1.14e-3;  ///< 0..10: of the wall under the finger
  double contact_n_per_m = 800;   ///< 100..1e5: K_c, see patch.h; above every K of the wall
  Contractile contractile;
  /// Of a ventricle whose wall is Table 1 as printed; `muscle` changes its emin, branch_elastance
  /// and relaxation_rate_per_s. Without infarct_*: they come from the segments.
  CirculationParameters circulation;
  /// 0 or 1..1000: of equation (2) [1/s]; 0: of `muscle`
  double relaxation_rate_per_s = 0;
  /// 0 or 20..250: while above 0 the resistance follows, beat by beat, to this mean aortic pressure
  double aortic_target_mmhg = 0;
  SegmentTissue segments{};
  /// Of the whole ventricle, where regions were found on an atlas (regions.h); none: the segments'.
  std::optional<Infarct> infarct = std::nullopt;

  /// @throws Error{InvalidInput} as palpation_from_json does of these numbers.
  void check() const;
  /// Of a place: Table 1 at the long axis, changed by the segment's tissue.
  [[nodiscard]] MuscleConstants at(double long_axis, int segment) const noexcept;
  [[nodiscard]] MuscleConstants at(double long_axis, const Tissue& tissue) const noexcept {
    return in_tissue(blend(muscle, long_axis), tissue);
  }
  /// The circulation with that infarct and this muscle around the ventricle: Emin and E_1 go with
  /// the means of k_h2 and k_h1 (the pressure of a spring k around a cylinder is k x1 / S0, x1 = V
  /// / S0: its elastance is k / S0^2, and S0 is the heart's), the rate is that of the table.
  [[nodiscard]] CirculationParameters whole_circulation() const noexcept;
};

/// What of a place's stiffness comes with the beat [N/m]: K_e(t) of equation (6) and what the
/// filling pressure adds. @param alpha of the place
[[nodiscard]] double contractile_n_per_m(const PalpationParameters& parameters, double alpha,
                                         const Circulation& circulation) noexcept;
[[nodiscard]] double pressure_n_per_m(const Circulation& circulation) noexcept;

/// An infarct weeks old, as in anterior_infarct.
[[nodiscard]] constexpr Tissue infarct_tissue() noexcept {
  return {.scar = 0.8, .thickness_ratio = 0.6, .alpha = 0.2};
}

/// healthy, anterior_infarct, dilated_cardiomyopathy, low_pressure, by_74_percent: a preset on the
/// dog of 25 kg. `reference_volume_ml` is that preset's own end-diastolic volume.
/// @throws Error{InvalidInput} naming the presets there are.
[[nodiscard]] PalpationParameters palpation_preset(const std::string& name);
[[nodiscard]] std::vector<std::string> palpation_presets();

/// schemas/palpation.schema.json. What is left out keeps its default. `regions` are checked and
/// left out: they are an atlas's, see regions_from_json.
/// @throws Error{InvalidInput} naming the JSON path of what is unknown or out of range, and the
/// range.
[[nodiscard]] PalpationParameters palpation_from_json(const nlohmann::json& json);
[[nodiscard]] nlohmann::json palpation_to_json(const PalpationParameters& parameters);

}  // namespace beatlas::palpation
