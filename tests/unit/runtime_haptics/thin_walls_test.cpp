// Hard cases 3 and 4: walls so thin that a distance alone loses its side.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "runtime/haptics/proxy.h"
#include "runtime/haptics/two_step.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics::thin_walls_tests {
namespace {

using testing::FormField;
using testing::made_sample;
using Field = std::shared_ptr<const ContactField>;

constexpr double kPi = std::numbers::pi;
constexpr double kTick = 0.001;
constexpr double kBeat = 0.75;
constexpr double kWallMm = 3;

Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

// A closed shell whose wall is 3 mm thick. Its middle radius swells by 6 mm with up to 50 mm/s,
// like a heart's wall at its quickest.
struct Shell {
  double radius_mm;
  double swell_mm;
  [[nodiscard]] double middle(double t) const {
    return radius_mm + swell_mm * std::sin(2 * kPi * t / kBeat);
  }
  [[nodiscard]] double distance(const Vec3& x, double t) const {
    return std::abs(x.norm() - middle(t)) - 0.5 * kWallMm;
  }
};

Field exact_shell(const Shell& shell) {
  return std::make_shared<const FormField>(2.0, kBeat, [shell](const Vec3& x, double t) {
    const double r = x.norm();
    const double side = r >= shell.middle(t) ? 1 : -1;
    const double speed = shell.swell_mm * 2 * kPi / kBeat * std::cos(2 * kPi * t / kBeat);
    const Vec3 away = r > 0 ? Vec3(x / r) : Vec3::UnitX();
    return made_sample(side * (r - shell.middle(t)) - 0.5 * kWallMm, side * away, -side * speed);
  });
}

// Straight paths at 0.1 to 1 m/s from outside to inside, or from the cavity out. Counts those on
// which the proxy was ever on the other side of the wall's middle.
int pop_throughs(const Field& field, const Shell& shell, double radius_mm, int paths,
                 std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(0, 1);
  ProxyModel model(field, {.radius_mm = radius_mm});
  int passed = 0;
  for (int path = 0; path < paths; ++path) {
    model.reset();
    const bool from_outside = path % 4 != 0;
    const double t0 = 10 * u(random);
    const double speed_mm_s = 100 + 900 * u(random);
    const double clear = 0.5 * kWallMm + radius_mm + 0.5;
    const Vec3 start =
        from_outside ? Vec3((shell.middle(t0) + clear + 2 * u(random)) * random_direction(random))
                     : Vec3(u(random) * (shell.middle(t0) - clear) * random_direction(random));
    const Vec3 towards = from_outside
                             ? Vec3(0.8 * shell.radius_mm * u(random) * random_direction(random))
                             : Vec3(2 * shell.radius_mm * random_direction(random));
    const Vec3 velocity = speed_mm_s * (towards - start).normalized();
    const double seconds = 1.5 * (towards - start).norm() / speed_mm_s;
    bool wrong = false;
    for (double s = 0; s < seconds && !wrong; s += kTick) {
      const Contact contact = model.evaluate(start + s * velocity, t0 + s);
      wrong = (contact.proxy_mm.norm() > shell.middle(t0 + s)) != from_outside ||
              !contact.force_n.allFinite();
    }
    passed += wrong ? 1 : 0;
  }
  return passed;
}

TEST(HardCase3, NoPathAtUpToOneMetrePerSecondPopsThroughAClosingWall) {
  const Shell shell{25, 6};
  EXPECT_EQ(pop_throughs(exact_shell(shell), shell, 0, 80000, 1), 0);
  EXPECT_EQ(pop_throughs(exact_shell(shell), shell, 3, 20000, 2), 0);
}

TEST(HardCase3, NorThroughTheWallOfAnAtlas) {
  const Shell shell{15, 3};
  const Field field =
      testing::packed({.origin_mm = Vec3::Constant(-30),
                       .blocks = {5, 5, 5},
                       .rr_interval_s = kBeat,
                       .inner_mm = 12,
                       .outer_mm = 6},
                      [&](const Vec3& x, double t) { return shell.distance(x, t); });
  EXPECT_EQ(pop_throughs(field, shell, 0, 8000, 3), 0);
  EXPECT_EQ(pop_throughs(field, shell, 2, 2000, 4), 0);
}

TEST(HardCase3, ADistanceAloneWouldPopThrough) {
  // What the test above counts does happen to a model without a proxy.
  const Shell shell{25, 6};
  const Field field = exact_shell(shell);
  const FieldSample past_the_middle = field->sample(Vec3(0, 0, shell.middle(0) - 1), 0);
  EXPECT_LT(past_the_middle.gradient.z(), 0);
}

// A plate of 1.5 voxels across the lattice at a slant.
constexpr double kVoxel = 1.5;
constexpr double kPlateMm = 1.5 * kVoxel;
const Vec3 kSlant = Vec3(2, -1, 3).normalized();

std::shared_ptr<const field::FieldQuery> plate() {
  return std::make_shared<const field::FieldQuery>(
      testing::dense_payload(
          {.origin_mm = Vec3::Constant(-18),
           .voxel_mm = kVoxel,
           .blocks = {3, 3, 3},
           .phases = 1,
           .inner_mm = 12,
           .outer_mm = 6},
          [](const Vec3& x, double) { return std::abs(kSlant.dot(x)) - 0.5 * kPlateMm; }),
      1);
}

TEST(HardCase4, AWallPushedPastItsMiddleKeepsTheForcesSign) {
  const auto field = plate();
  ProxyModel proxy(std::make_shared<const AtlasField>(field), {});
  TwoStepModel distance_alone(field, {});
  int flips = 0;
  int flips_of_distance = 0;
  double last_n = 0;
  // From a voxel outside to three thicknesses behind the wall, at 50 mm/s.
  for (double z = kVoxel; z > -3 * kPlateMm; z -= 0.05) {
    const Vec3 x = Vec3(0.4, -0.7, 0.2) + z * kSlant;
    const Vec3 force_n = proxy.evaluate(x, 0).force_n;
    const double along = force_n.dot(kSlant);
    if (along < 0 || along < last_n - 1e-4) ++flips;
    // No spline follows the kink in the middle of 1.5 voxels: the stored surface is wavy, by 0.12
    // mm here, and the proxy lies in a hollow of it, less than a voxel aside.
    EXPECT_NEAR(along, 0.150 * std::max(0.0, 0.5 * kPlateMm - kSlant.dot(x)), 0.150 * 0.2);
    EXPECT_LT((force_n - along * kSlant).norm(), 0.150 * kVoxel);
    last_n = along;
    if (distance_alone.evaluate(x, 0).force_n.dot(kSlant) < -1e-3) ++flips_of_distance;
  }
  EXPECT_EQ(flips, 0);
  EXPECT_GT(last_n, 0.150 * 3 * kPlateMm);
  EXPECT_GT(flips_of_distance, 0);  // so the case is a hard one
}

TEST(HardCase4, AlsoAfterAGapBetweenTicks) {
  // A plate that moves by 2 mm between two ticks, nearly its own thickness: carried in parts.
  const Field field = std::make_shared<const FormField>(1.5, 1e3, [](const Vec3& x, double t) {
    const double z = x.z() - 200 * t;
    const double side = z >= 0 ? 1 : -1;
    return made_sample(side * z - 0.5 * kPlateMm, side * Vec3::UnitZ(), -side * 200);
  });
  ProxyModel model(field, {});
  const Vec3 x(0, 0, 0.5 * kPlateMm - 0.1);
  EXPECT_TRUE(model.evaluate(x, 0.000).touching);
  const Contact after = model.evaluate(x, 0.010);
  EXPECT_NEAR(after.force_n.z(), 0.150 * 2.1, 1e-6);
}

}  // namespace
}  // namespace beatlas::haptics::thin_walls_tests
