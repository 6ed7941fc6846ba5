#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/phantom/phantom.h"
#include "tests/unit/phantom/reference_heart.h"

namespace beatlas::phantom::distance_tests {
namespace {

using beatlas::test::ReferenceHeart;

const double kTimes[] = {0.0, 0.17, 0.36, 0.47};  // end diastole, ejection, end systole, filling

Vec3 random_point(std::mt19937& random, double reach_mm) {
  std::uniform_real_distribution<double> uniform(-reach_mm, reach_mm);
  const double x = uniform(random);
  const double y = uniform(random);
  const double z = uniform(random);
  return {x, y, z};
}

/// A query that is hard: on or beside a surface, on an axis or plane of symmetry, or anywhere.
Vec3 hard_point(std::mt19937& random, int n, const std::vector<Vec3>& surface) {
  Vec3 x = random_point(random, 90.0);
  switch (n % 5) {
    case 0:
      return x;
    case 1:
      return surface[random() % surface.size()] + 0.05 * x;
    case 2:
      x.x() = x.y() = 0.0;
      return x;
    case 3:
      x.y() = 0.0;
      return x;
    default:
      return surface[random() % surface.size()] + 0.3 * x;
  }
}

TEST(PhantomDistance, EqualsExhaustiveSearchOfEverySurface) {
  const Phantom phantom(preset("adult"));
  const Affine lps_from_heart = phantom::lps_from_heart(phantom.spec().anatomy);
  std::mt19937 random(7);
  constexpr double kResolutionMm = 1e-3;
  double worst_face = 0.0;
  double worst_crease = 0.0;
  int creases = 0;
  int kind = 0;  // of hard_point, in turn
  for (double t : kTimes) {
    const ReferenceHeart reference = ReferenceHeart::at(ReferenceHeart::loss(t));
    const auto frame = phantom.frame(t);
    for (Part part : kAllParts) {
      std::vector<Vec3> surface = frame->sample_surface(part, 4.0);
      for (Vec3& x : surface) x = lps_from_heart.inverse() * x;
      for (int n = 0; n < (part == Part::Pericardium ? 1 : 2); ++n) {
        const Vec3 x = hard_point(random, kind++, surface);
        const double brute = reference.brute_distance(part, x, kResolutionMm);
        const Nearest nearest = frame->nearest(part, lps_from_heart * x);
        const double exact = std::abs(nearest.distance_mm);
        EXPECT_EQ(nearest.distance_mm < 0, reference.contains(part, x))
            << part_name(part) << " t " << t << " at " << x.transpose();
        // Beside a crease, too, the search cannot tell what is cut off better than it is fine.
        const bool crease =
            nearest.faces[1] >= 0 || frame->crease_distance_mm(part, nearest.point) < 0.4;
        // 1e-6 mm is for what the two know of s.
        const double slack = 1e-6 + (crease ? kResolutionMm : ReferenceHeart::kToleranceMm);
        EXPECT_LT(exact, brute + 1e-6) << part_name(part) << " t " << t << " at " << x.transpose();
        EXPECT_GT(exact, brute - slack)
            << part_name(part) << " t " << t << " at " << x.transpose() << " exact " << exact;
        double& worst = crease ? worst_crease : worst_face;
        worst = std::max(worst, std::abs(exact - brute));
        creases += crease;
      }
    }
  }
  EXPECT_LT(worst_face, 1e-3);
  EXPECT_LT(worst_crease, 1e-3);
  EXPECT_GT(creases, 10) << "the points must try creases, too";
  RecordProperty("worst_face_um", static_cast<int>(worst_face * 1e3));
  std::printf("worst difference: %.2e mm on faces, %.2e mm on creases\n", worst_face, worst_crease);
}

TEST(PhantomDistance, IsNeverSteeperThanOne) {
  // A candidate missed on one side of a medial surface would show as a jump.
  const Phantom phantom(preset("adult"));
  const Vec3 origin = phantom.spec().anatomy.origin_lps_mm;
  std::mt19937 random(11);
  for (double t : kTimes) {
    const auto frame = phantom.frame(t);
    for (Part part : kAllParts) {
      for (int line = 0; line < 40; ++line) {
        const Vec3 from = origin + random_point(random, 90.0);
        const Vec3 to = origin + random_point(random, 90.0);
        constexpr int kSteps = 200;
        double last = frame->distance_mm(part, from);
        for (int n = 1; n <= kSteps; ++n) {
          const double next = frame->distance_mm(part, from + (to - from) * n / kSteps);
          ASSERT_LE(std::abs(next - last), (to - from).norm() / kSteps + 2e-7)
              << part_name(part) << " t " << t;
          last = next;
        }
      }
    }
  }
}

TEST(PhantomDistance, ChangesByOneMillimetreAMillimetreAlongTheNormal) {
  const Phantom phantom(preset("adult"));
  for (double t : kTimes) {
    const auto frame = phantom.frame(t);
    for (Part part : kAllParts) {
      int tried = 0;
      for (const Vec3& x : frame->sample_surface(part, 4.0)) {
        // Clefts, as between an atrium and the base it stands on, open within 4 mm of their crease
        // to more than the steps below.
        if (frame->crease_distance_mm(part, x) < 4.0) continue;
        // On the surface the distance is 0 and the normal that of the face.
        EXPECT_NEAR(frame->distance_mm(part, x), 0.0, 2e-7);
        const Vec3 n = frame->nearest(part, x).outward;
        EXPECT_NEAR(n.norm(), 1.0, 1e-12);
        for (double step : {-0.5, 0.5}) {
          EXPECT_NEAR(frame->distance_mm(part, x + step * n), step, 1e-6)
              << part_name(part) << " t " << t;
          EXPECT_GT(frame->nearest(part, x + step * n).outward.dot(n), 1.0 - 1e-9);
        }
        ++tried;
      }
      EXPECT_GT(tried, 30) << part_name(part);
    }
  }
}

TEST(PhantomDistance, VelocityIsTheRateOfTheDistance) {
  const Phantom phantom(preset("adult"));
  const Vec3 origin = phantom.spec().anatomy.origin_lps_mm;
  std::mt19937 random(19);
  constexpr double kStepS = 1e-5;
  double fastest = 0.0;
  int compared = 0;
  for (double t : {0.12, 0.2, 0.45, 0.66}) {
    const auto before = phantom.frame(t - kStepS);
    const auto now = phantom.frame(t);
    const auto after = phantom.frame(t + kStepS);
    for (Part part : kAllParts) {
      for (int n = 0; n < 60; ++n) {
        const Vec3 x = origin + random_point(random, 80.0);
        // Where the nearest point jumps to another place the distance has no rate.
        if ((before->nearest(part, x).point - after->nearest(part, x).point).norm() > 0.01)
          continue;
        const double expected =
            (before->distance_mm(part, x) - after->distance_mm(part, x)) / (2.0 * kStepS);
        const double stated = phantom.velocity_mm_s(part, x, t);
        // 0.03 mm/s: distances to 1e-7 mm over 2e-5 s, and their third derivative.
        EXPECT_NEAR(stated, expected, 0.03)
            << part_name(part) << " t " << t << " faces " << now->nearest(part, x).faces[1];
        fastest = std::max(fastest, std::abs(stated));
        ++compared;
      }
    }
  }
  EXPECT_GT(fastest, 50.0);
  EXPECT_GT(compared, 2000);
}

TEST(PhantomDistance, VelocityOfTheBaseIsThatOfItsPlane) {
  const Phantom phantom(preset("adult"));
  const Affine lps_from_heart = phantom::lps_from_heart(phantom.spec().anatomy);
  for (double t : {0.12, 0.2, 0.45, 0.66}) {
    const double ahead = ReferenceHeart::at(ReferenceHeart::loss(t + 1e-3)).base;
    const double behind = ReferenceHeart::at(ReferenceHeart::loss(t - 1e-3)).base;
    const double expected = (ahead - behind) / 2e-3;
    const double base = ReferenceHeart::at(ReferenceHeart::loss(t)).base;
    for (double depth : {-1.0, 0.0, 2.0}) {
      const Vec3 x = lps_from_heart * Vec3(3.0, -4.0, base + depth);
      // 0.2 mm/s: third derivative of the base over the reference's step of 1 ms.
      EXPECT_NEAR(phantom.velocity_mm_s(Part::LvBlood, x, t), expected, 0.2);
    }
    EXPECT_GT(std::abs(expected), 10.0);
  }
}

TEST(PhantomDistance, TheFreeWallMovesInwardInEjection) {
  const Phantom phantom(preset("adult"));
  const Affine lps_from_heart = phantom::lps_from_heart(phantom.spec().anatomy);
  const Vec3 lateral = lps_from_heart * Vec3(-35.5, 0.0, 0.0);
  EXPECT_LT(phantom.velocity_mm_s(Part::Heart, lateral, 0.15), -5.0);
  EXPECT_GT(phantom.velocity_mm_s(Part::Heart, lateral, 0.46), 5.0);
  EXPECT_NEAR(phantom.velocity_mm_s(Part::Heart, lateral, 0.36), 0.0, 1e-3);
}

TEST(PhantomDistance, SamplesLieOnTheSurfaceAndCoverIt) {
  const Phantom phantom(preset("adult"));
  std::mt19937 random(3);
  constexpr double kSpacingMm = 3.0;
  for (Part part : kAllParts) {
    const auto frame = phantom.frame(0.2);
    const std::vector<Vec3> points = frame->sample_surface(part, kSpacingMm);
    for (const Vec3& x : points) ASSERT_NEAR(frame->distance_mm(part, x), 0.0, 2e-7);
    for (int n = 0; n < 300; ++n) {
      const Vec3 near =
          frame->nearest(part, phantom.spec().anatomy.origin_lps_mm + random_point(random, 90.0))
              .point;
      double gap = 1e300;
      for (const Vec3& x : points) gap = std::min(gap, (x - near).norm());
      EXPECT_LT(gap, 1.5 * kSpacingMm) << part_name(part);
    }
  }
}

}  // namespace
}  // namespace beatlas::phantom::distance_tests
