#include "pipeline/phantom/material.h"

#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/phantom/heart_shape.h"
#include "pipeline/phantom/phantom.h"

namespace beatlas::phantom {
namespace {

constexpr double kMoments[] = {0.0, 0.35, 1.0};

TEST(MaterialPoints, OfTheWallsFacesStayOnThem) {
  const Anatomy anatomy;
  for (double s : kMoments) {
    const Frame frame(anatomy, s);
    const Affine lps = lps_from_heart(anatomy);
    for (double height : {0.05, 0.4, 0.9}) {
      for (double angle : {0.3, 2.0, 5.0}) {
        const Vec3 inner = lps * position_mm(anatomy, {height, angle, 0.0}, s);
        const Vec3 outer = lps * position_mm(anatomy, {height, angle, 1.0}, s);
        EXPECT_NEAR(frame.distance_mm(Part::LvBlood, inner), 0.0, 1e-6);
        EXPECT_NEAR(frame.distance_mm(Part::LvMyocardium, outer), 0.0, 1e-6);
        EXPECT_TRUE(frame.contains(Part::LvMyocardium,
                                   lps * position_mm(anatomy, {height, angle, 0.5}, s)));
      }
    }
  }
}

TEST(MaterialPoints, OfAPlaceAreThoseThatLieThere) {
  Anatomy anatomy;
  anatomy.torsion_deg = 14.0;
  anatomy.scale = 0.8;
  for (double s : kMoments) {
    for (double mural : {0.0, 0.6, 1.0}) {
      const Vec3 place = position_mm(anatomy, {0.35, 1.2, mural}, s);
      const MaterialPoint found = material_at(anatomy, place, mural, s);
      EXPECT_NEAR(found.height, 0.35, 1e-12);
      EXPECT_NEAR(found.angle_rad, 1.2, 1e-12);
      EXPECT_NEAR((position_mm(anatomy, found, s) - place).norm(), 0.0, 1e-9);
    }
  }
}

TEST(MaterialPoints, AShellKeepsItsShareOfTheMuscle) {
  Anatomy anatomy;
  anatomy.scale = 0.9;
  for (double s : kMoments) {
    const double base = heart_shape(anatomy, s).lv_base_z_mm;
    const auto volume = [&](double mural) {
      return cut_ellipsoid_ml(lv_shell(anatomy, s, mural), base);
    };
    for (double mural : {0.25, 0.5, 0.8}) {
      EXPECT_NEAR((volume(mural) - volume(0.0)) / (volume(1.0) - volume(0.0)), mural, 1e-12);
    }
  }
}

TEST(MaterialPoints, TorsionTurnsTheApexAgainstTheBase) {
  Anatomy anatomy;
  const Vec3 still = position_mm(anatomy, {0.25, 1.0, 0.5}, 1.0);
  EXPECT_NEAR(std::atan2(still.y(), still.x()), 1.0, 1e-12);
  anatomy.torsion_deg = 12.0;
  const Vec3 turned = position_mm(anatomy, {0.25, 1.0, 0.5}, 1.0);
  EXPECT_NEAR(std::atan2(turned.y(), turned.x()), 1.0 + 0.75 * 12.0 * M_PI / 180.0, 1e-12);
  EXPECT_NEAR(turned.z(), still.z(), 1e-12);
  EXPECT_NEAR(turned.norm(), still.norm(), 1e-9);
  const Vec3 rest = position_mm(anatomy, {0.25, 1.0, 0.5}, 0.0);
  EXPECT_NEAR(std::atan2(rest.y(), rest.x()), 1.0, 1e-12);
  const Vec3 base = position_mm(anatomy, {1.0, 1.0, 0.5}, 1.0);
  EXPECT_NEAR(std::atan2(base.y(), base.x()), 1.0, 1e-12);
  // The surfaces are round: only what stands in the cavity shows it.
  const Frame plain(Anatomy{}, 1.0);
  const Frame twisted(anatomy, 1.0);
  const Vec3 x = lps_from_heart(anatomy) * Vec3(8.0, 5.0, -20.0);
  EXPECT_EQ(plain.distance_mm(Part::LvBlood, x), twisted.distance_mm(Part::LvBlood, x));
  EXPECT_NE(plain.distance_mm(Part::PapillaryMuscles, x),
            twisted.distance_mm(Part::PapillaryMuscles, x));
}

}  // namespace
}  // namespace beatlas::phantom
