#include "runtime/palpation/muscle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/palpation/oscillator.h"
#include "runtime/palpation/units.h"

namespace beatlas::palpation {
namespace {

constexpr double kThinnest = 0.3;
constexpr double kThickest = 2;
constexpr double kSoftest = 0.1;
constexpr double kStiffest = 10;

constexpr std::array<double MuscleConstants::*, 5> kMembers{
    &MuscleConstants::k_h1_n_per_m, &MuscleConstants::k_h2_n_per_m, &MuscleConstants::c_h_n_s_per_m,
    &MuscleConstants::k_v_n_per_m, &MuscleConstants::c_v_n_s_per_m};

}  // namespace

double MuscleTable::relaxation_rate_per_s() const noexcept {
  double sum = 0;
  for (const MuscleConstants* place : {&base, &middle, &apex}) {
    sum += place->k_h1_n_per_m / place->c_h_n_s_per_m;
  }
  return sum / 3;
}

double MuscleTable::mean_k_h1_n_per_m() const noexcept {
  return (base.k_h1_n_per_m + middle.k_h1_n_per_m + apex.k_h1_n_per_m) / 3;
}

double MuscleTable::mean_k_h2_n_per_m() const noexcept {
  return (base.k_h2_n_per_m + middle.k_h2_n_per_m + apex.k_h2_n_per_m) / 3;
}

MuscleConstants blend(const MuscleTable& table, double long_axis) noexcept {
  const double along = std::clamp(3 * long_axis - 0.5, 0.0, 2.0);  // 0 apex, 1 middle, 2 base
  if (along == 1) return table.middle;
  const MuscleConstants& low = along < 1 ? table.apex : table.middle;
  const MuscleConstants& high = along < 1 ? table.middle : table.base;
  const double share = along < 1 ? along : along - 1;
  if (share == 0) return low;
  if (share == 1) return high;
  MuscleConstants out;
  for (const auto member : kMembers) {
    out.*member = low.*member * std::pow(high.*member / (low.*member), share);
  }
  return out;
}

MuscleConstants in_tissue(const MuscleConstants& healthy, const Tissue& tissue) noexcept {
  const double thickness = std::clamp(tissue.thickness_ratio, kThinnest, kThickest);
  const double stiffer = (1 + kScarStiffening * std::clamp(tissue.scar, 0.0, 1.0)) *
                         std::clamp(tissue.stiffness_ratio, kSoftest, kStiffest);
  MuscleConstants out = healthy;
  out.k_v_n_per_m *= stiffer * thickness * thickness;
  out.c_v_n_s_per_m *= stiffer * thickness * thickness;
  out.k_h2_n_per_m *= stiffer * thickness;
  return out;
}

double Cylinder::side_area_cm2() const noexcept {
  return std::numbers::pi * diameter_cm * length_cm;
}

Cylinder cylinder_of(double volume_ml) noexcept {
  constexpr double kSlenderness = 1.6;
  const double diameter_cm = std::cbrt(4 * volume_ml / (std::numbers::pi * kSlenderness));
  return {diameter_cm, kSlenderness * diameter_cm};
}

double shortening_area_cm2(double contracting_ml, double reference_ml) noexcept {
  return contracting_ml / cylinder_of(reference_ml).length_cm;
}

double pressure_n_per_m(double filling_mmhg, double reference_ml) noexcept {
  constexpr double kMPerCm = 0.01;
  const double radius_m = 0.5 * kMPerCm * cylinder_of(reference_ml).diameter_cm;
  return std::numbers::pi * kPaPerMmhg * std::max(filling_mmhg, 0.0) * radius_m;
}

double Contractile::stiffness_n_per_m(double alpha, double beat_area_cm2,
                                      double elastance_mmhg_per_ml) const noexcept {
  const double area_cm2 = shortening_area_cm2 > 0 ? shortening_area_cm2 : beat_area_cm2;
  return alpha * area_cm2 * finger_area_cm2 * kM2PerCm2 * kM2PerCm2 * elastance_mmhg_per_ml *
         kPaPerMmhg / kM3PerMl;
}

HorizontalMuscle::HorizontalMuscle(double k_h1_n_per_m, double k_h2_n_per_m,
                                   double c_h_n_s_per_m) noexcept
    : k1_(k_h1_n_per_m), k2_(k_h2_n_per_m), rate_per_s_(k_h1_n_per_m / c_h_n_s_per_m) {}

void HorizontalMuscle::set(double k_h1_n_per_m, double k_h2_n_per_m,
                           double c_h_n_s_per_m) noexcept {
  k1_ = k_h1_n_per_m;
  k2_ = k_h2_n_per_m;
  rate_per_s_ = k_h1_n_per_m / c_h_n_s_per_m;
}

double HorizontalMuscle::relax(double stretch_m, double step_s) noexcept {
  const double z = -rate_per_s_ * step_s;
  branch_n_ = std::exp(z) * branch_n_ + k1_ * (stretch_m - stretch_m_) * phi1(z);
  stretch_m_ = stretch_m;
  return force_n();
}

double HorizontalMuscle::contract(double stretch_m, double contractile_n_per_m) noexcept {
  stretch_m_ = stretch_m;
  branch_n_ = contractile_n_per_m * stretch_m;
  return force_n();
}

double HorizontalMuscle::energy_j() const noexcept {
  return 0.5 * k2_ * stretch_m_ * stretch_m_ + 0.5 * branch_n_ * branch_n_ / k1_;
}

}  // namespace beatlas::palpation
