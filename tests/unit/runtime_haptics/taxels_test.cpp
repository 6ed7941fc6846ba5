#include "runtime/haptics/taxels.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/haptics/proxy.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics::taxels_tests {
namespace {

using testing::FormField;
using testing::made_sample;

constexpr int kSide = TaxelMap::kSide;

std::shared_ptr<const ContactField> plane() {
  return std::make_shared<const FormField>(
      1.5, 1, [](const Vec3& x, double) { return made_sample(x.z(), Vec3::UnitZ()); });
}

std::shared_ptr<const ContactField> ball(double radius_mm) {
  return std::make_shared<const FormField>(1.5, 1, [radius_mm](const Vec3& x, double) {
    return made_sample((x + radius_mm * Vec3::UnitZ()).norm() - radius_mm,
                       (x + radius_mm * Vec3::UnitZ()).normalized());
  });
}

/// A ball that has gone `depth_mm` into what lies below z = 0, and is pushed up with 1.5 N.
BallContact pressed(double radius_mm, double depth_mm) {
  return {.proxy_mm = radius_mm * Vec3::UnitZ(),
          .normal = Vec3::UnitZ(),
          .force_n = 1.5 * Vec3::UnitZ(),
          .depth_mm = depth_mm};
}

/// The sum of a map's pressures [N].
double force_of(const TaxelMap& map) {
  double sum = 0;
  for (const float p : map.pressure_kpa) sum += static_cast<double>(p);
  return sum * map.pitch_mm * map.pitch_mm * 1e-3;
}

/// Hertz's pressure, mean of a taxel [kPa], by a sum over 100 x 100 places.
double hertz_kpa(int row, int column, double pitch_mm, double force_n, double a_mm) {
  constexpr int kFine = 100;
  const double p0 = 1000 * 3 * force_n / (2 * std::numbers::pi * a_mm * a_mm);
  double sum = 0;
  for (int j = 0; j < kFine; ++j) {
    for (int i = 0; i < kFine; ++i) {
      const double u = (column - kSide / 2 + (i + 0.5) / kFine) * pitch_mm;
      const double v = (row - kSide / 2 + (j + 0.5) / kFine) * pitch_mm;
      sum += p0 * std::sqrt(std::max(0.0, 1 - (u * u + v * v) / (a_mm * a_mm)));
    }
  }
  return sum / (kFine * kFine);
}

void expect_hertz(const TaxelMap& map, double force_n, double a_mm) {
  const double p0 = 1000 * 3 * force_n / (2 * std::numbers::pi * a_mm * a_mm);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      EXPECT_NEAR(map.pressure_kpa[static_cast<std::size_t>(row * kSide + column)],
                  hertz_kpa(row, column, map.pitch_mm, force_n, a_mm), 0.02 * p0)
          << row << ' ' << column;
    }
  }
  EXPECT_NEAR(map.peak_kpa, p0, 0.05 * p0);
  const double area = std::numbers::pi * a_mm * a_mm;
  EXPECT_NEAR(map.area_mm2, area, 0.05 * area);
  EXPECT_NEAR(force_of(map), force_n, 1e-5 * force_n);
}

TEST(Taxels, ABallOnAPlaneIsHertzs) {
  for (const double radius : {4.0, 8.0}) {
    Taxels taxels(plane(), {.radius_mm = radius});
    for (const double depth : {0.5, 1.0, 2.0, 4.0}) {
      SCOPED_TRACE(depth);
      expect_hertz(taxels.under(pressed(radius, depth), 0), 1.5, std::sqrt(radius * depth));
    }
  }
}

// 1 / R = 1 / 8 + 1 / 40.
TEST(Taxels, ABallOnABallIsHertzsOfBothCurvatures) {
  Taxels taxels(ball(40), {.radius_mm = 8});
  const double radius = 1 / (1.0 / 8 + 1.0 / 40);
  expect_hertz(taxels.under(pressed(8, 2), 0), 1.5, std::sqrt(radius * 2));
}

TEST(Taxels, AnAtlasShowsWhatItsClosedFormDoes) {
  const Vec3 axes(20, 15, 25);
  const auto field =
      testing::packed({.origin_mm = Vec3::Constant(-35), .blocks = {6, 6, 6}, .phases = 1},
                      [&](const Vec3& x, double) { return testing::ellipsoid_distance(axes, x); });
  const auto exact = std::make_shared<const FormField>(1.5, 1, [&](const Vec3& x, double) {
    return made_sample(testing::ellipsoid_distance(axes, x), Vec3::Zero());
  });
  ProxyModel model(field, {.radius_mm = 5});
  (void)model.evaluate(Vec3(0, 0, 30), 0);
  const Contact contact = model.evaluate(Vec3(0, 0, 28), 0);
  ASSERT_TRUE(contact.touching);
  const BallContact of_model{.proxy_mm = contact.proxy_mm,
                             .normal = contact.normal,
                             .force_n = contact.force_n,
                             .depth_mm = contact.depth_mm};
  const TaxelMap found = Taxels(field, {.radius_mm = 5}).under(of_model, 0);
  const TaxelMap truth = Taxels(exact, {.radius_mm = 5}).under(of_model, 0);
  EXPECT_NEAR(force_of(found), contact.force_n.norm(), 0.01 * contact.force_n.norm());
  EXPECT_NEAR(found.area_mm2, truth.area_mm2, 0.05 * truth.area_mm2);
  for (std::size_t n = 0; n < found.pressure_kpa.size(); ++n) {
    EXPECT_NEAR(found.pressure_kpa[n], truth.pressure_kpa[n], 0.05 * truth.peak_kpa) << n;
  }
  // The ellipsoid is flatter along y than along x: 15 and 20 mm over a height of 25.
  EXPECT_GT(found.pressure_kpa[4 * kSide + 6], found.pressure_kpa[6 * kSide + 4]);
}

class Lump final : public StiffnessMap {
 public:
  [[nodiscard]] double n_per_m(const Vec3& at, double) const noexcept override {
    return (at - Vec3(3, 0, 0)).norm() < 1.5 ? 450 : 150;
  }
};

TEST(Taxels, AHardSpotShowsWhereItLies) {
  const BallContact contact = pressed(8, 3);
  const TaxelMap even = Taxels(plane(), {.radius_mm = 8}).under(contact, 0);
  const TaxelMap lump =
      Taxels(plane(), {.radius_mm = 8, .map = std::make_shared<const Lump>()}).under(contact, 0);
  // Columns 5 and 2 lie 2 to 4 mm right and left of the middle.
  for (const int row : {3, 4}) {
    const auto right = static_cast<std::size_t>(row * kSide + 5);
    const auto left = static_cast<std::size_t>(row * kSide + 2);
    EXPECT_NEAR(even.pressure_kpa[right], even.pressure_kpa[left], 1e-3);
    EXPECT_GT(lump.pressure_kpa[right], 1.4F * lump.pressure_kpa[left]);
  }
  EXPECT_NEAR(force_of(lump), 1.5, 1e-4);
}

TEST(Taxels, AnEdgeIsFeltOnItsOwnSide) {
  // A step down of the body where x > 2 mm.
  const auto step = std::make_shared<const FormField>(1.5, 1, [](const Vec3& x, double) {
    return made_sample(x.x() > 2 ? x.z() + 5 : x.z(), Vec3::UnitZ());
  });
  const TaxelMap map = Taxels(step, {.radius_mm = 8}).under(pressed(8, 4), 0);
  EXPECT_GT(map.pressure_kpa[4 * kSide + 2], 0);
  EXPECT_EQ(map.pressure_kpa[4 * kSide + 6], 0);
}

TEST(Taxels, ColumnsRunWhereTheyAreWishedTo) {
  BallContact contact = pressed(8, 3);
  contact.right = Vec3(0, 1, 1);
  const TaxelMap map = Taxels(plane(), {.radius_mm = 8}).under(contact, 0);
  EXPECT_LT((map.right - Vec3::UnitY()).norm(), 1e-12);
  EXPECT_LT((map.up + Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT((map.centre_mm - Vec3::Zero()).norm(), 1e-12);
  contact.right = Vec3::UnitZ();  // along the normal: any will do
  const TaxelMap any = Taxels(plane(), {.radius_mm = 8}).under(contact, 0);
  EXPECT_NEAR(any.right.norm(), 1, 1e-12);
  EXPECT_NEAR(any.right.dot(Vec3::UnitZ()), 0, 1e-12);
}

TEST(Taxels, NothingIsFeltWhereNothingIsTouched) {
  Taxels taxels(plane(), {.radius_mm = 8});
  BallContact contact = pressed(8, 2);
  const auto silent = [&](const BallContact& of) {
    const TaxelMap map = taxels.under(of, 0);
    EXPECT_EQ(map.area_mm2, 0);
    EXPECT_EQ(map.peak_kpa, 0);
    for (const float p : map.pressure_kpa) EXPECT_EQ(p, 0);
  };
  silent({});
  contact.depth_mm = 0;
  silent(contact);
  contact = pressed(8, 2);
  contact.force_n = -contact.force_n;
  silent(contact);
  contact.force_n = Vec3(0, 0, std::numeric_limits<double>::quiet_NaN());
  silent(contact);
  contact = pressed(8, 2);
  contact.proxy_mm.x() = std::numeric_limits<double>::infinity();
  silent(contact);
}

TEST(Taxels, OptionsThatMakeNoSenseAreRefused) {
  EXPECT_THROW(Taxels(nullptr, {}), Error);
  EXPECT_THROW(Taxels(plane(), {.radius_mm = 0}), Error);
  EXPECT_THROW(Taxels(plane(), {.radius_mm = 60}), Error);
  EXPECT_THROW(Taxels(plane(), {.radius_mm = 8, .pitch_mm = 30}), Error);
  EXPECT_THROW(Taxels(plane(), {.radius_mm = 8, .pitch_mm = -1}), Error);
}

}  // namespace
}  // namespace beatlas::haptics::taxels_tests
