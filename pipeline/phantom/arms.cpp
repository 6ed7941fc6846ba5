#include "pipeline/phantom/arms.h"

#include <algorithm>
#include <limits>

namespace beatlas::phantom {
namespace {

constexpr double kMiddleMm = -14.0;  // of the chest, beside the heart
constexpr double kAsideMm = 175.0;
constexpr double kSkinMm = 36.0;

double growth(const Anatomy& anatomy) { return std::max(1.0, anatomy.scale); }

}  // namespace

std::vector<ThoraxBody> arms(const Anatomy& anatomy, const Signals& signals) {
  const double k = growth(anatomy);
  std::vector<ThoraxBody> out;
  for (const double side : {-1.0, 1.0}) {
    const Vec3 centre = anatomy.origin_lps_mm + k * Vec3(kMiddleMm + side * kAsideMm, 15.0, 0.0);
    const auto cylinder = [&](double semi_x, double semi_y, double signal) {
      const double endless = std::numeric_limits<double>::infinity();
      out.push_back({Ellipsoid{centre, {k * semi_x, k * semi_y, endless}}, signal});
    };
    cylinder(kSkinMm, 42.0, signals.fat);
    cylinder(30.0, 36.0, signals.muscle);
    cylinder(11.0, 11.0, signals.bone);
  }
  return out;
}

double arms_reach_mm(const Anatomy& anatomy) {
  return growth(anatomy) * (kAsideMm + kSkinMm - kMiddleMm);
}

}  // namespace beatlas::phantom
