#include "pipeline/keyframes/key_heart.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/keyframes/periodic_spline.h"
#include "runtime/base/error.h"

namespace beatlas::keyframes::key_heart_tests {
namespace {

constexpr double kPi = std::numbers::pi;
const Vec3 kCentre(5, -7, 11);
const std::vector<double> kKeyAt{0, 0.2, 0.5, 0.75};

// A ball of rings, its poles along z; closed, outward.
field::TriangleSoup ball(double radius_mm, int rings = 60, int columns = 90) {
  field::TriangleSoup out;
  out.points.push_back(kCentre - Vec3(0, 0, radius_mm));
  for (int ring = 1; ring < rings; ++ring) {
    const double angle = kPi * ring / rings;
    for (int n = 0; n < columns; ++n) {
      const double turn = 2 * kPi * n / columns;
      out.points.push_back(kCentre + radius_mm * Vec3(std::sin(angle) * std::cos(turn),
                                                      std::sin(angle) * std::sin(turn),
                                                      -std::cos(angle)));
    }
  }
  out.points.push_back(kCentre + Vec3(0, 0, radius_mm));
  const auto last = static_cast<std::uint32_t>(out.points.size() - 1);
  const auto at = [&](int ring, int n) {
    return static_cast<std::uint32_t>(1 + (ring - 1) * columns + n % columns);
  };
  for (int n = 0; n < columns; ++n) {
    out.triangles.push_back({0, at(1, n + 1), at(1, n)});
    for (int ring = 1; ring + 1 < rings; ++ring) {
      out.triangles.push_back({at(ring, n), at(ring, n + 1), at(ring + 1, n + 1)});
      out.triangles.push_back({at(ring, n), at(ring + 1, n + 1), at(ring + 1, n)});
    }
    out.triangles.push_back({at(rings - 1, n), at(rings - 1, n + 1), last});
  }
  return out;
}

double outer_mm(double share) { return 24 + 3 * std::cos(2 * kPi * share); }
double inner_mm(double share) { return 15 + 4 * std::cos(2 * kPi * share); }

KeyHeart beating_balls(bool own_triangles) {
  KeyHeart heart;
  heart.rr_interval_s = 0.8;
  heart.phases = 8;
  heart.key_at = kKeyAt;
  for (std::size_t n = 0; n < kKeyAt.size(); ++n) {
    const int rings = own_triangles ? 60 + static_cast<int>(n) : 60;
    heart.surfaces[Structure::Heart].push_back(ball(outer_mm(kKeyAt[n]), rings));
    heart.surfaces[Structure::LvBlood].push_back(ball(inner_mm(kKeyAt[n]), rings));
  }
  return heart;
}

// What the spline through the keys' radii gives: the keys' balls grow evenly.
double between(double share, double (*radius)(double)) {
  Eigen::VectorXd keys(static_cast<Eigen::Index>(kKeyAt.size()));
  for (std::size_t n = 0; n < kKeyAt.size(); ++n) {
    keys[static_cast<Eigen::Index>(n)] = radius(kKeyAt[n]);
  }
  return PeriodicSpline(kKeyAt).weights(share).dot(keys);
}

// The polyhedra of these balls are 0.3 % smaller than the balls.
TEST(KeyHeart, ImagesAndLabelsHoldTheVolumesOfEveryPhase) {
  for (const bool own_triangles : {false, true}) {
    StageContext context;
    const SeenHeart seen = see_heart(beating_balls(own_triangles), context);
    const Cine& stack = seen.exam.stack;
    ASSERT_EQ(stack.phase_count(), 8);
    ASSERT_EQ(seen.labels.phase_count(), 8);
    for (int phase = 0; phase < 8; ++phase) {
      const double share = phase / 8.0;
      const auto p = static_cast<std::size_t>(phase);
      EXPECT_NEAR(stack.frame_times_s[p], 0.8 * share, 1e-12);
      const double blood = 4 * kPi / 3 * std::pow(between(share, inner_mm), 3) / 1000;
      const double heart = 4 * kPi / 3 * std::pow(between(share, outer_mm), 3) / 1000;
      double brightness = 0;  // of blood and muscle above what lies outside
      for (const float value : stack.images.phases[p]) brightness += (value - 80) * 1e-3;
      const double exact = blood * (1000 - 80) + (heart - blood) * (400 - 80);
      EXPECT_NEAR(brightness / exact, 1, 0.006) << phase;
      const auto& labels = seen.labels.phases[p];
      const auto ml = [&](std::uint8_t label) {
        return 1e-3 * static_cast<double>(std::count(labels.begin(), labels.end(), label));
      };
      EXPECT_NEAR(ml(kLabelLvBlood) / blood, 1, 0.01) << phase;
      EXPECT_NEAR(ml(kLabelLvMyocardium) / (heart - blood), 1, 0.01) << phase;
      EXPECT_EQ(ml(kLabelRestOfHeart) + ml(kLabelRvBlood), 0);
    }
  }
}

// A key at 0, one at a fifth of the beat, then one every 25th: a spline without a bound would carry
// the last stroke before the beat's end on into the contraction.
TEST(KeyHeart, GrowsNoLargerThanItsKeysWhereTheyAreUneven) {
  const std::vector<double> ml{119.9, 77, 69.5, 62,   57.5, 53,   51,   51,   53, 58.5, 66,
                               74.5,  81, 86,   89.5, 92,   93.5, 94.5, 95.5, 98, 103.9};
  KeyHeart heart;
  heart.rr_interval_s = 1;
  heart.phases = 20;
  for (std::size_t n = 0; n < ml.size(); ++n) {
    heart.key_at.push_back(n == 0 ? 0 : 0.16 + 0.04 * static_cast<double>(n));
    heart.surfaces[Structure::LvBlood].push_back(ball(15 * std::cbrt(ml[n] / ml[0]), 40, 60));
    heart.surfaces[Structure::Heart].push_back(ball(19, 40, 60));
  }
  const PeriodicSpline free(heart.key_at);
  Eigen::VectorXd radius(static_cast<Eigen::Index>(ml.size()));
  for (std::size_t n = 0; n < ml.size(); ++n) {
    radius[static_cast<Eigen::Index>(n)] = 15 * std::cbrt(ml[n] / ml[0]);
  }
  ASSERT_GT(std::pow(free.weights(0.05).dot(radius) / 15, 3), 1.02) << "or the case is none";
  StageContext context;
  const SeenHeart seen = see_heart(heart, context);
  const auto voxels = [&](std::size_t phase) {
    const auto& labels = seen.labels.phases[phase];
    return static_cast<double>(std::count(labels.begin(), labels.end(), kLabelLvBlood));
  };
  // Of 14 000 voxels those on the edge are counted by chance, some tens.
  for (std::size_t phase = 1; phase < 20; ++phase) {
    EXPECT_LT(voxels(phase) / voxels(0), 1.005) << phase;
  }
  EXPECT_EQ(seen.exam.decisions.size(), 2U) << "that it bends with a jump is told";
}

TEST(KeyHeart, ARightVentricleLeavesTheRestUntold) {
  KeyHeart heart = beating_balls(false);
  heart.surfaces[Structure::RvBlood] = std::move(heart.surfaces[Structure::LvBlood]);
  heart.surfaces.erase(Structure::LvBlood);
  StageContext context;
  const SeenHeart seen = see_heart(heart, context);
  const auto& labels = seen.labels.phases[0];
  EXPECT_GT(std::count(labels.begin(), labels.end(), kLabelRestOfHeart), 10000);
  EXPECT_GT(std::count(labels.begin(), labels.end(), kLabelRvBlood), 10000);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), kLabelLvMyocardium), 0);
}

TEST(KeyHeart, IsTheSameForAnyNumberOfThreads) {
  StageContext context;
  const KeyHeart heart = beating_balls(true);
  set_thread_count(1);
  const SeenHeart one = see_heart(heart, context);
  set_thread_count(3);
  const SeenHeart three = see_heart(heart, context);
  set_thread_count(0);
  EXPECT_EQ(one.exam.stack.images.phases, three.exam.stack.images.phases);
  EXPECT_EQ(one.labels.phases, three.labels.phases);
}

std::string refusal(const KeyHeart& heart) {
  StageContext context;
  try {
    (void)see_heart(heart, context);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return "";
}

TEST(KeyHeart, SaysWhatItCannotUse) {
  const auto said = [](const auto& change) {
    KeyHeart heart = beating_balls(false);
    change(heart);
    return refusal(heart);
  };
  const std::string open =
      said([](KeyHeart& heart) { heart.surfaces[Structure::LvBlood][2].triangles.pop_back(); });
  EXPECT_NE(open.find("key surface 3 of lv_blood is not closed: 3 edges"), std::string::npos)
      << open;
  EXPECT_NE(said([](KeyHeart& heart) { heart.surfaces.erase(Structure::Heart); }).find("heart"),
            std::string::npos);
  EXPECT_NE(said([](KeyHeart& heart) {
              heart.surfaces[Structure::Heart].pop_back();
            }).find("3 key surfaces for 4"),
            std::string::npos);
  EXPECT_NE(said([](KeyHeart& heart) { heart.voxel_mm = 0.1; }).find("0.3 to 5"),
            std::string::npos);
  EXPECT_NE(said([](KeyHeart& heart) { heart.phases = 2; }).find("3 to 200"), std::string::npos);
  EXPECT_NE(said([](KeyHeart& heart) {
              for (auto& key : heart.surfaces[Structure::Heart]) {
                for (Vec3& point : key.points) point *= 1000;
              }
            }).find("3e8 voxels"),
            std::string::npos);
  EXPECT_NE(said([](KeyHeart& heart) {
              heart.surfaces[Structure::Heart][0].points[5].x() = std::nan("");
            }).find("no place"),
            std::string::npos);
}

TEST(KeyHeart, DistancesOfManyKeysCountAsImagesDo) {
  KeyHeart heart;
  heart.rr_interval_s = 0.8;
  heart.phases = 3;
  constexpr int kKeys = 150;
  for (int n = 0; n < kKeys; ++n) {
    heart.key_at.push_back(static_cast<double>(n) / kKeys);
    heart.surfaces[Structure::Heart].push_back(ball(60, 6 + n % 2, 6));
  }
  EXPECT_NE(refusal(heart).find("3e8 voxels"), std::string::npos) << "2.5e6 of each of 153";
}

}  // namespace
}  // namespace beatlas::keyframes::key_heart_tests
