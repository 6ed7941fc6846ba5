#include "runtime/haptics/shell.h"

#include <cmath>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics::shell_tests {
namespace {

using testing::FormField;
using testing::made_sample;
using Field = std::shared_ptr<const ContactField>;

constexpr double kPi = std::numbers::pi;
constexpr double kBed = 1.5e6 * 1e-9;  // N/mm^3

Field floor_below() {
  return std::make_shared<const FormField>(
      1.5, 1, [](const Vec3& x, double t) { return made_sample(x.z() - t, Vec3::UnitZ(), -1); });
}

Field ellipsoid() {
  static const Vec3 axes(20, 15, 25);
  static const Field field =
      testing::packed({.origin_mm = Vec3::Constant(-35), .blocks = {6, 6, 6}, .phases = 1},
                      [](const Vec3& x, double) { return testing::ellipsoid_distance(axes, x); });
  return field;
}

TEST(Fingertip, CoversHalfASphereEvenly) {
  const Shell shell = fingertip(8, 10000);
  double area = 0;
  Vec3 first_moment = Vec3::Zero();
  for (std::size_t n = 0; n < shell.points_mm.size(); ++n) {
    EXPECT_NEAR(shell.points_mm[n].norm(), 8, 1e-9);
    EXPECT_LT(shell.points_mm[n].z(), 0);
    area += shell.areas_mm2[n];
    first_moment += shell.areas_mm2[n] * shell.points_mm[n];
  }
  EXPECT_NEAR(area, 2 * kPi * 64, 1e-9);
  EXPECT_LT((first_moment / area - Vec3(0, 0, -4)).norm(), 0.01);
}

// A cap of a sphere of radius a, depth d, on a flat bed: dA = 2 pi a dh, so F = pi a c d^2.
TEST(ShellModel, AFingertipOnAFlatBedFeelsTheClosedForm) {
  for (std::size_t points : {std::size_t{1000}, Shell::kMostPoints}) {
    ShellModel model(floor_below(), fingertip(8, points), {});
    for (double depth : {0.5, 1.0, 2.0, 4.0}) {
      const Contact contact = model.evaluate({.position_mm = Vec3(3, -2, 8 - depth)}, {});
      const double exact = kPi * 8 * kBed * depth * depth;
      // Depths are sampled at the middle of rings of 8 / points mm: exact but for the ring cut.
      EXPECT_NEAR(contact.force_n.z(), exact, kPi * 8 * kBed * std::pow(8.0 / points, 2));
      EXPECT_TRUE(contact.touching);
      EXPECT_NEAR(contact.depth_mm, depth, 8.0 / static_cast<double>(points));
      EXPECT_LT((contact.normal - Vec3::UnitZ()).norm(), 1e-9);
      EXPECT_LT(contact.torque_n_mm.norm(), 0.01 * 8 * exact);
      EXPECT_NEAR(contact.surface_velocity_mm_s, 1, 1e-12);
    }
  }
}

// A plate of 2w x 2h, tilted by a small angle s about y, d deep at its centre and nowhere out of
// the bed: F = c A d, M_y = -c sin(s) A w^2 / 3.
TEST(ShellModel, ATiltedPlateFeelsTheTorqueOfItsSecondMoment) {
  Shell plate;
  constexpr int kSide = 100;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      plate.points_mm.emplace_back(-6 + 12 * (i + 0.5) / kSide, -4 + 8 * (j + 0.5) / kSide, 0);
      plate.areas_mm2.push_back(96.0 / (kSide * kSide));
    }
  }
  ShellModel model(floor_below(), plate, {});
  constexpr double kTilt = 0.1;
  const ServoState state{
      .position_mm = Vec3(0, 0, -2),
      .orientation = Eigen::Quaterniond(Eigen::AngleAxisd(kTilt, Vec3::UnitY()))};
  const Contact contact = model.evaluate(state, {});
  EXPECT_NEAR(contact.force_n.z(), kBed * 96 * 2, 1e-9);
  // Point (x, y, 0) goes to (x cos s, y, -x sin s): deeper by x sin s, its lever x cos s.
  const double second = 96 * 36.0 / 3;
  EXPECT_NEAR(contact.torque_n_mm.y(), -kBed * second * std::sin(kTilt) * std::cos(kTilt),
              1e-3 * kBed * second * kTilt);
  EXPECT_NEAR(contact.torque_n_mm.x(), 0, 1e-9);
}

TEST(ShellModel, PassingOverClustersChangesNothing) {
  const Shell shell = fingertip(7, 3000);
  const Field field = ellipsoid();
  ShellModel model(field, shell, {});
  for (int n = 0; n < 40; ++n) {
    const Vec3 direction =
        Vec3(std::sin(0.7 * n), std::cos(1.1 * n), std::sin(0.3 * n)).normalized();
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), direction);
    const Vec3 x = (18 + 0.3 * n) * direction;
    Vec3 force = Vec3::Zero();
    for (std::size_t i = 0; i < shell.points_mm.size(); ++i) {
      const FieldSample sample = field->sample(x + turn * shell.points_mm[i], 0);
      if (sample.distance_mm < 0) {
        force -= kBed * shell.areas_mm2[i] * sample.distance_mm * sample.gradient.normalized();
      }
    }
    const Contact contact = model.evaluate({.position_mm = x, .orientation = turn}, {});
    EXPECT_LT((contact.force_n - force).norm(), 1e-9) << n;
    EXPECT_EQ(contact.touching, force.norm() > 0);
    if (!contact.touching) {
      EXPECT_LE(model.samples(), 3000U);
    }
  }
  (void)model.evaluate({.position_mm = Vec3(0, 0, 34)}, {});
  EXPECT_LT(model.samples(), 100U);  // far away the middle alone, or the clusters, decide
}

// A batch is faster than single queries, and nothing else.
TEST(ContactBatch, AnswersAsSingleQueriesDoToTheBit) {
  const Field beating =
      testing::packed({.origin_mm = Vec3::Constant(-24), .inner_mm = 9, .outer_mm = 6},
                      [](const Vec3& x, double t) { return x.norm() - 15 - 2 * std::sin(8 * t); });
  const std::vector<Field> fields{floor_below(), ellipsoid(), beating,
                                  std::make_shared<const HeldField>(beating, 0.21)};
  const Shell shell = fingertip(7, 3000);
  std::vector<Vec3> points(shell.points_mm.size());
  std::vector<FieldSample> found(points.size());
  for (const Field& field : fields) {
    for (const double width_mm : {1.0, 14.0}) {  // narrower than the shell: slower, not otherwise
      const auto batch = field->batch(width_mm);
      for (int tick = 0; tick < 30; ++tick) {
        const double t = 0.03 * tick;
        const Vec3 at = (10 + 0.5 * tick) * Vec3(std::sin(tick), std::cos(tick), 0.3).normalized();
        for (std::size_t n = 0; n < points.size(); ++n) points[n] = at + shell.points_mm[n];
        const std::size_t asked = tick % 3 == 0 ? 5 : points.size();
        const std::span<const Vec3> some = std::span<const Vec3>(points).first(asked);
        batch->sample(some, t, std::span<FieldSample>(found).first(asked));
        for (std::size_t n = 0; n < asked; ++n) {
          const FieldSample one = field->sample(points[n], t);
          ASSERT_EQ(found[n].distance_mm, one.distance_mm);
          ASSERT_EQ(found[n].gradient, one.gradient);
          ASSERT_EQ(found[n].rate_mm_s, one.rate_mm_s);
          ASSERT_EQ(found[n].in_band, one.in_band);
        }
      }
    }
  }
}

TEST(ShellModel, RefusesWhatIsNoShell) {
  EXPECT_THROW(ShellModel(nullptr, fingertip(5, 10), {}), Error);
  EXPECT_THROW(ShellModel(floor_below(), {}, {}), Error);
  EXPECT_THROW(ShellModel(floor_below(), {{Vec3::Zero()}, {}}, {}), Error);
  EXPECT_THROW(ShellModel(floor_below(), {{Vec3(0, std::nan(""), 0)}, {1}}, {}), Error);
  EXPECT_THROW(ShellModel(floor_below(), {{Vec3::Zero()}, {-1}}, {}), Error);
  EXPECT_THROW(ShellModel(floor_below(), fingertip(5, 10), {.foundation_n_per_m3 = 0}), Error);
  EXPECT_THROW((void)fingertip(0, 10), Error);
  EXPECT_THROW((void)fingertip(5, 10001), Error);
}

}  // namespace
}  // namespace beatlas::haptics::shell_tests
