#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "pipeline/phantom/motion.h"
#include "pipeline/phantom/phantom.h"
#include "pipeline/phantom/signals.h"
#include "pipeline/phantom/thorax.h"
#include "pipeline/phantom/truth.h"
#include "tests/unit/phantom/reference_heart.h"

namespace beatlas::phantom::shape_tests {
namespace {

using beatlas::test::ReferenceHeart;

constexpr double kEndDiastole = 0.0;
constexpr double kEndSystole = 0.36;

TEST(PhantomShape, VolumesAreThoseOfTheTable) {
  const Phantom phantom(preset("adult"));
  // The table prints three digits: half of the last, and for the RV, printed rounded, 1 ml and 1 %.
  EXPECT_NEAR(phantom.volume_ml(Part::LvBlood, kEndDiastole), 158.0, 0.5);
  EXPECT_NEAR(phantom.volume_ml(Part::LvBlood, kEndSystole), 54.0, 0.5);
  EXPECT_NEAR(phantom.volume_ml(Part::RvBlood, kEndDiastole), 190.0, 1.9);
  EXPECT_NEAR(phantom.volume_ml(Part::RvBlood, kEndSystole), 78.0, 1.0);
  for (double t : {0.0, 0.1, 0.2, 0.36, 0.5, 0.7}) {
    EXPECT_NEAR(phantom.volume_ml(Part::LvMyocardium, t), 132.5, 0.1);
  }
  EXPECT_NEAR(1.0 - phantom.volume_ml(Part::LvBlood, kEndSystole) /
                        phantom.volume_ml(Part::LvBlood, kEndDiastole),
              0.658, 0.002);
}

TEST(PhantomShape, VolumesEqualTheCountOfFineVoxels) {
  const Phantom phantom(preset("adult"));
  constexpr double kEdgeMm = 0.5;
  for (double t : {0.0, 0.2, 0.36}) {
    const ReferenceHeart reference = ReferenceHeart::at(ReferenceHeart::loss(t));
    std::array<std::size_t, kAllParts.size()> counts{};
    for (double z = -76; z < 100; z += kEdgeMm) {
      for (double y = -54; y < 58; y += kEdgeMm) {
        for (double x = -46; x < 82; x += kEdgeMm) {
          for (Part part : kAllParts) {
            counts[static_cast<std::size_t>(part)] +=
                reference.contains(part, {x + 0.01, y + 0.01, z + 0.01});
          }
        }
      }
    }
    for (Part part : kAllParts) {
      const double counted = static_cast<double>(counts[static_cast<std::size_t>(part)]) * kEdgeMm *
                             kEdgeMm * kEdgeMm * 1e-3;
      EXPECT_NEAR(phantom.volume_ml(part, t) / counted, 1.0, 0.005)
          << part_name(part) << " t " << t;
    }
  }
}

TEST(PhantomShape, VolumesEqualClosedForms) {
  // Two spheres of 20 mm with centres d apart, on a slant across z, cut by planes or not.
  const double r = 20.0;
  for (double d : {5.0, 19.0, 39.0}) {
    const Ellipsoid a{Vec3::Zero(), Vec3::Constant(r)};
    const Ellipsoid b{Vec3(2, 1, 2) * (d / 3.0), Vec3::Constant(r)};
    const double ball = 4.0 / 3.0 * M_PI * r * r * r * 1e-3;
    const double lens = M_PI * (4 * r + d) * (2 * r - d) * (2 * r - d) / 12.0 * 1e-3;
    const std::vector<Cell> both{{{0, true}, {1, true}}};
    const std::vector<Cell> either{{{0, true}}, {{1, true}}};
    const std::vector<Cell> one_only{{{0, true}, {1, false}}};
    EXPECT_NEAR(Solid({a, b}, both).volume_ml(), lens, 1e-4) << d;
    EXPECT_NEAR(Solid({a, b}, either).volume_ml(), 2 * ball - lens, 1e-4) << d;
    EXPECT_NEAR(Solid({a, b}, one_only).volume_ml(), ball - lens, 1e-4) << d;
  }
  // Steinmetz would need crossed cylinders; a bored ball is what two parallel ones cannot hide.
  const double bore = 8.0;
  const double half = std::sqrt(r * r - bore * bore);
  const double endless = std::numeric_limits<double>::infinity();
  const Solid ring({Ellipsoid{Vec3(1, 2, 3), Vec3::Constant(r)},
                    Ellipsoid{Vec3(1, 2, 0), Vec3(bore, bore, endless)}},
                   {{{0, true}, {1, false}}});
  EXPECT_NEAR(ring.volume_ml(), 4.0 / 3.0 * M_PI * half * half * half * 1e-3, 1e-4);
  const Ellipsoid cup{Vec3(0, 0, 2), Vec3(27, 20, 62)};
  EXPECT_NEAR(Solid({cup, Below{31.0}}, {{{0, true}, {1, true}}}).volume_ml(),
              cut_ellipsoid_ml(cup, 31.0), 1e-4);
}

TEST(PhantomShape, AtriaHaveTheVolumesOfTheTable) {
  const Phantom phantom(preset("adult"));
  // 45 and 103 ml are whole spheres; the valve plane and the aorta take up to 3 %.
  EXPECT_NEAR(phantom.volume_ml(Part::LaBlood, kEndDiastole), 45.0, 0.03 * 45.0);
  EXPECT_NEAR(phantom.volume_ml(Part::LaBlood, kEndSystole), 103.0, 0.03 * 103.0);
}

TEST(PhantomShape, PartsMayBeLeftOut) {
  PhantomSpec spec = preset("adult");
  spec.anatomy.atria.present = false;
  spec.anatomy.aorta.present = false;
  spec.anatomy.papillary_muscles.present = false;
  spec.anatomy.pericardial_fat.present = false;
  const Phantom phantom(spec);
  const auto frame = phantom.frame(0.1);
  for (Part part : kAllParts) EXPECT_EQ(frame->has(part), part <= Part::RvWall) << part_name(part);
  EXPECT_TRUE(std::isinf(frame->distance_mm(Part::LaBlood, Vec3::Zero())));
  EXPECT_FALSE(frame->contains(Part::Aorta, Vec3::Zero()));
  EXPECT_EQ(frame->volume_ml(Part::RaBlood), 0.0);
  EXPECT_EQ(truth_json(phantom).at("structures").size(), 5U);
  // The filled heart then ends at the base planes.
  const Vec3 above = lps_from_heart(spec.anatomy) * Vec3(-12.0, -14.0, 31.0);
  EXPECT_FALSE(phantom.contains(Part::Heart, above, 0.0));
  EXPECT_TRUE(Phantom(preset("adult")).contains(Part::Heart, above, 0.0));
}

TEST(PhantomShape, AnInfarctIsThinAndStill) {
  PhantomSpec spec = preset("adult");
  spec.anatomy.infarct.present = true;
  const Phantom phantom(spec);
  const Infarct& infarct = spec.anatomy.infarct;
  const double angle = infarct.angle_deg * M_PI / 180.0;
  const Vec3 out(std::cos(angle), std::sin(angle), 0.0);
  const Affine lps = lps_from_heart(spec.anatomy);
  const auto wall_mm = [&](const Vec3& direction, double t) {
    double length = 0.0;
    for (double r = 0.0; r < 60.0; r += 0.05) {
      const Vec3 x = lps * Vec3(r * direction + Vec3(0, 0, infarct.z_mm));
      length += phantom.contains(Part::LvMyocardium, x, t) ? 0.05 : 0.0;
    }
    return length;
  };
  EXPECT_LT(wall_mm(out, kEndDiastole), 0.75 * wall_mm(-out, kEndDiastole));
  EXPECT_LT(wall_mm(out, kEndSystole), 0.5 * wall_mm(-out, kEndSystole));
  EXPECT_NEAR(wall_mm(out, kEndSystole), wall_mm(out, kEndDiastole), 0.1);
  const Vec3 x = lps * Vec3(26.0 * out + Vec3(0, 0, infarct.z_mm));
  EXPECT_NEAR(phantom.velocity_mm_s(Part::LvBlood, x, 0.15), 0.0, 1e-6);
  // The muscle is that of the whole heart to a few per cent.
  for (double t : {0.0, 0.15, kEndSystole}) {
    EXPECT_NEAR(phantom.volume_ml(Part::LvMyocardium, t), 132.5, 0.12 * 132.5) << t;
  }
}

TEST(PhantomShape, VolumeLossHasItsLandmarks) {
  EXPECT_DOUBLE_EQ(volume_loss(0.0, 0.75), 0.0);
  EXPECT_NEAR(volume_loss(0.049, 0.75), 0.0, 1e-15);
  EXPECT_NEAR(volume_loss(0.36, 0.75), 1.0, 1e-12);
  EXPECT_NEAR(volume_loss(0.58, 0.75), 0.25, 1e-12);  // diastasis
  EXPECT_NEAR(volume_loss(0.74, 0.75), 0.0, 1e-12);
  EXPECT_NEAR(volume_loss(0.2, 0.75), volume_loss(0.2 * 1.2 + 0.9, 0.9), 1e-12);
  for (double t : {0.1, 0.2, 0.3, 0.42, 0.5, 0.65}) {
    EXPECT_NEAR(volume_loss(t, 0.75), ReferenceHeart::loss(t), 1e-8) << t;
  }
}

TEST(PhantomShape, HeartTouchesNothingOfTheThorax) {
  for (double scale : {0.7, 1.0, 1.25}) {
    PhantomSpec spec = preset("adult");
    spec.anatomy.scale = scale;
    const Phantom phantom(spec);
    const auto tissues = thorax(spec.anatomy, Signals{});
    for (double t : {0.0, 0.2, 0.36}) {
      for (const Vec3& x : phantom.sample_surface(Part::Heart, t, 3.0)) {
        for (std::size_t n = 0; n < tissues.size(); ++n) {
          const double distance = tissues[n].surface(x).distance_mm;
          // Inside of skin, muscle and lung field, outside of what lies in it.
          EXPECT_GT(n < 3 ? -distance : distance, 3.0) << "tissue " << n << " scale " << scale;
        }
      }
    }
  }
}

TEST(PhantomShape, HardHasTheLiverInTouchAtRest) {
  const Phantom phantom(preset("hard"));
  const std::vector<ThoraxBody> tissues = thorax(phantom.spec().anatomy, signals_preset("A"));
  const ThoraxBody& liver = tissues[3];
  ASSERT_EQ(liver.signal, signals_preset("A").liver);
  constexpr double kSpacingMm = 2.0;
  const auto touch = [&](double t) {
    int touching = 0;
    double deepest = 1e300;
    for (const Vec3& x : phantom.sample_surface(Part::Heart, t, kSpacingMm)) {
      const double distance = liver.surface(x).distance_mm;
      touching += distance < 0.0;
      deepest = std::min(deepest, distance);
    }
    return std::pair(touching * kSpacingMm * kSpacingMm, deepest);
  };
  // A patch of some 12 mm radius, a few millimetres deep; the contracted heart is clear of it.
  EXPECT_NEAR(touch(kEndDiastole).first, M_PI * 12.0 * 12.0, 150.0);
  EXPECT_GT(touch(kEndDiastole).second, -5.0);
  EXPECT_GT(touch(kEndSystole).second, 2.0);
}

TEST(PhantomShape, LengthsScale) {
  PhantomSpec spec = preset("adult");
  const Phantom one(spec);
  spec.anatomy.scale = 0.8;
  const Phantom small(spec);
  const Vec3 origin = spec.anatomy.origin_lps_mm;
  for (Part part : kAllParts) {
    EXPECT_NEAR(small.volume_ml(part, 0.2), 0.512 * one.volume_ml(part, 0.2), 1e-4);
    const Vec3 x(10.0, -20.0, 15.0);
    EXPECT_NEAR(small.distance_mm(part, origin + 0.8 * x, 0.2),
                0.8 * one.distance_mm(part, origin + x, 0.2), 1e-6);
  }
}

}  // namespace
}  // namespace beatlas::phantom::shape_tests
