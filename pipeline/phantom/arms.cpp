#include "pipeline/phantom/arms.h"

#include <algorithm>

namespace beatlas::phantom {
namespace {

constexpr double kAsideMm = 175.0;
constexpr double kSkinMm = 36.0;

double growth(const Anatomy& anatomy) { return std::max(1.0, anatomy.scale); }

}  // namespace

std::vector<Tissue> arms(const Anatomy& anatomy, const Signals& signals) {
  const double k = growth(anatomy);
  std::vector<Tissue> out;
  for (const double side : {-1.0, 1.0}) {
    const Vec3 centre = anatomy.origin_lps_mm + k * Vec3(side * kAsideMm, 15.0, 0.0);
    out.push_back({Ellipse{centre, k * kSkinMm, k * 42.0}, signals.fat});
    out.push_back({Ellipse{centre, k * 30.0, k * 36.0}, signals.muscle});
    out.push_back({Ellipse{centre, k * 11.0, k * 11.0}, signals.bone});
  }
  return out;
}

double arms_reach_mm(const Anatomy& anatomy) { return growth(anatomy) * (kAsideMm + kSkinMm); }

}  // namespace beatlas::phantom
