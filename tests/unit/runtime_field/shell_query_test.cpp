#include "runtime/field/shell_query.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas::field::shell_query_tests {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRr = 0.75;

std::shared_ptr<const FieldQuery> beating_sphere() {
  static const auto query = std::make_shared<const FieldQuery>(
      ::beatlas::testing::dense_payload(
          {.origin_mm = Vec3(-24, -25, -23), .inner_mm = 9, .outer_mm = 6},
          [](const Vec3& x, double t) { return x.norm() - 15 - 2 * std::sin(2 * kPi * t / kRr); }),
      kRr);
  return query;
}

/// Blocks of all three kinds about a corner where they meet.
std::shared_ptr<const FieldQuery> patchwork() {
  auto payload = std::make_shared<atlas::FieldPayload>(beating_sphere()->payload());
  const std::size_t leaf = payload->coefficients.size() / payload->leaf_count();
  std::vector<std::int16_t> kept;
  std::int32_t leaves = 0;
  for (std::size_t b = 0; b < payload->blocks.size(); ++b) {
    if (b % 3 == 2) {
      const auto from = payload->coefficients.begin() + static_cast<std::ptrdiff_t>(b * leaf);
      kept.insert(kept.end(), from, from + static_cast<std::ptrdiff_t>(leaf));
      payload->blocks[b] = leaves++;
    } else {
      payload->blocks[b] =
          b % 3 == 0 ? atlas::FieldPayload::kOutside : atlas::FieldPayload::kInside;
    }
  }
  payload->coefficients = std::move(kept);
  return std::make_shared<const FieldQuery>(payload, kRr);
}

std::vector<Vec3> shell(const Vec3& centre, double radius_mm, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Vec3> out;
  for (int n = 0; n < count; ++n) {
    const Vec3 direction(normal(random), normal(random), normal(random));
    out.emplace_back(centre + radius_mm * direction.normalized());
  }
  return out;
}

void expect_same(const FieldQuery& query, const std::vector<Vec3>& x, double t,
                 const std::vector<FieldSample>& found) {
  for (std::size_t n = 0; n < x.size(); ++n) {
    const FieldSample one = query.sample(x[n], t);
    ASSERT_EQ(found[n].distance_mm, one.distance_mm) << n << " at " << t;
    ASSERT_EQ(found[n].gradient, one.gradient);
    ASSERT_EQ(found[n].rate_mm_s, one.rate_mm_s);
    ASSERT_EQ(found[n].in_band, one.in_band);
  }
}

TEST(ShellQuery, AnswersAsFieldQueryDoesAtAnyPlaceAndTime) {
  for (const auto& query : {beating_sphere(), patchwork()}) {
    ShellQuery shells(query);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> u(-30, 30);
    for (int round = 0; round < 60; ++round) {
      // From wholly inside the lattice to wholly outside; some shells wider than the scratch.
      const Vec3 centre(u(random), u(random), u(random));
      const auto x = shell(centre, 1 + std::abs(u(random)), 500, static_cast<unsigned>(round));
      const double t = 0.1 * u(random);
      std::vector<FieldSample> found(x.size());
      shells.sample(x, t, found);
      expect_same(*query, x, t, found);
    }
  }
}

TEST(ShellQuery, AnswersTheSameWithoutRoomForABoxAndForFewPointsFarApart) {
  const auto query = beating_sphere();
  const auto x = shell(Vec3(12, 3, -4), 6, 400, 1);
  std::vector<FieldSample> found(x.size());
  ShellQuery without_room(query, 0);
  without_room.sample(x, 0.2, found);
  expect_same(*query, x, 0.2, found);
  ShellQuery shells(query);
  const std::vector<Vec3> few{Vec3(-20, -20, -20), Vec3(20, 20, 20)};
  shells.sample(few, 0.2, found);
  expect_same(*query, few, 0.2, found);
  shells.sample({}, 0.2, found);
}

TEST(ShellQuery, WhatIsNoPlaceOrTimeIsFarOutside) {
  const auto query = beating_sphere();
  ShellQuery shells(query);
  auto x = shell(Vec3(12, 3, -4), 6, 400, 1);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  x[3].y() = kNan;
  x[7].z() = -kInfinity;
  x[8].x() = 1e300;
  std::vector<FieldSample> found(x.size());
  shells.sample(x, 0.3, found);
  expect_same(*query, x, 0.3, found);
  EXPECT_EQ(found[3].distance_mm, 6);
  EXPECT_EQ(found[7].distance_mm, 6);
  shells.sample(x, kNan, found);
  for (const FieldSample& each : found) EXPECT_EQ(each.distance_mm, 6);
}

TEST(ShellQuery, WritesNoMoreThanThereIsRoomFor) {
  ShellQuery shells(beating_sphere());
  const auto x = shell(Vec3(12, 3, -4), 6, 400, 1);
  std::vector<FieldSample> found(x.size());
  found[200].distance_mm = 77;
  shells.sample(x, 0.1, std::span(found).first(200));
  EXPECT_EQ(found[200].distance_mm, 77);
  EXPECT_NE(found[199].distance_mm, 0);
  EXPECT_THROW(ShellQuery(nullptr), Error);
  static_assert(noexcept(shells.sample(x, 0.1, found)));
}

}  // namespace
}  // namespace beatlas::field::shell_query_tests
