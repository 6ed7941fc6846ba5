#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/phantom/motion.h"
#include "pipeline/phantom/phantom.h"
#include "pipeline/phantom/thorax.h"
#include "pipeline/phantom/truth.h"
#include "tests/unit/phantom/reference_heart.h"

namespace beatlas::phantom {
namespace {

using test::ReferenceHeart;

constexpr double kEndDiastole = 0.0;
constexpr double kEndSystole = 0.36;

TEST(PhantomShape, VolumesAreThoseOfTheTable) {
  const Phantom phantom(preset("adult"));
  // The table prints three digits: half of the last, and for the RV, printed rounded, 1 ml and 1 %.
  EXPECT_NEAR(phantom.volume_ml(Structure::LvBlood, kEndDiastole), 158.0, 0.5);
  EXPECT_NEAR(phantom.volume_ml(Structure::LvBlood, kEndSystole), 54.0, 0.5);
  EXPECT_NEAR(phantom.volume_ml(Structure::RvBlood, kEndDiastole), 190.0, 1.9);
  EXPECT_NEAR(phantom.volume_ml(Structure::RvBlood, kEndSystole), 78.0, 1.0);
  for (double t : {0.0, 0.1, 0.2, 0.36, 0.5, 0.7}) {
    EXPECT_NEAR(phantom.volume_ml(Structure::LvMyocardium, t), 132.5, 0.1);
  }
  EXPECT_NEAR(1.0 - phantom.volume_ml(Structure::LvBlood, kEndSystole) /
                        phantom.volume_ml(Structure::LvBlood, kEndDiastole),
              0.658, 0.002);
}

TEST(PhantomShape, VolumesEqualTheCountOfFineVoxels) {
  const Phantom phantom(preset("adult"));
  constexpr double kEdgeMm = 0.5;
  for (double t : {0.0, 0.2, 0.36}) {
    const ReferenceHeart reference = ReferenceHeart::at(ReferenceHeart::loss(t));
    std::array<std::size_t, kAllStructures.size()> counts{};
    for (double z = -72; z < 40; z += kEdgeMm) {
      for (double y = -50; y < 50; y += kEdgeMm) {
        for (double x = -40; x < 70; x += kEdgeMm) {
          for (Structure structure : kAllStructures) {
            counts[static_cast<std::size_t>(structure)] +=
                reference.contains(structure, {x + 0.01, y + 0.01, z + 0.01});
          }
        }
      }
    }
    for (Structure structure : kAllStructures) {
      const double counted = static_cast<double>(counts[static_cast<std::size_t>(structure)]) *
                             kEdgeMm * kEdgeMm * kEdgeMm * 1e-3;
      EXPECT_NEAR(phantom.volume_ml(structure, t) / counted, 1.0, 0.005)
          << structure_name(structure) << " t " << t;
    }
  }
}

TEST(PhantomShape, CommonVolumeOfEqualSpheresIsTheLens) {
  const double r = 20.0;
  for (double d : {5.0, 19.0, 39.0}) {
    const Ellipsoid a{Vec3::Zero(), Vec3::Constant(r)};
    const Ellipsoid b{{d, 0, 0}, Vec3::Constant(r)};
    const double lens = M_PI * (4 * r + d) * (2 * r - d) * (2 * r - d) / 12.0 * 1e-3;
    EXPECT_NEAR(common_ml(a, b, 100.0), lens, 1e-5);
    EXPECT_NEAR(common_ml(a, b, 0.0), 0.5 * lens, 1e-5);
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
      for (const Vec3& x : phantom.sample_surface(Structure::Heart, t, 3.0)) {
        for (std::size_t n = 0; n < tissues.size(); ++n) {
          const double distance = tissues[n].surface(x).distance_mm;
          // Inside of skin, muscle and lung field, outside of what lies in it.
          EXPECT_GT(n < 3 ? -distance : distance, 3.0) << "tissue " << n << " scale " << scale;
        }
      }
    }
  }
}

TEST(PhantomShape, LengthsScale) {
  PhantomSpec spec = preset("adult");
  const Phantom one(spec);
  spec.anatomy.scale = 0.8;
  const Phantom small(spec);
  const Vec3 origin = spec.anatomy.origin_lps_mm;
  for (Structure structure : kAllStructures) {
    EXPECT_NEAR(small.volume_ml(structure, 0.2), 0.512 * one.volume_ml(structure, 0.2), 1e-4);
    const Vec3 x(10.0, -20.0, 15.0);
    EXPECT_NEAR(small.distance_mm(structure, origin + 0.8 * x, 0.2),
                0.8 * one.distance_mm(structure, origin + x, 0.2), 1e-6);
  }
}

}  // namespace
}  // namespace beatlas::phantom
