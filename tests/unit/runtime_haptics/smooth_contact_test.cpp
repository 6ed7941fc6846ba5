// Hard cases 1, 2 and 8: smooth bodies, still and beating, against closed form.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/haptics/proxy.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics::smooth_contact_tests {
namespace {

using testing::FormField;
using testing::made_sample;
using Field = std::shared_ptr<const ContactField>;

constexpr double kPi = std::numbers::pi;
constexpr double kTick = 0.001;
const Vec3 kAxes(45, 35, 60);

double degrees_between(const Vec3& a, const Vec3& b) {
  return 180 / kPi * std::atan2(a.cross(b).norm(), a.dot(b));
}

Field exact_ellipsoid() {
  return std::make_shared<const FormField>(1.5, 0.8, [](const Vec3& x, double) {
    const Vec3 foot = testing::ellipsoid_nearest(kAxes, x);
    return made_sample(testing::ellipsoid_distance(kAxes, x),
                       foot.cwiseQuotient(kAxes.cwiseAbs2()).normalized());
  });
}

Field packed_ellipsoid() {
  static const Field field =
      testing::packed({.origin_mm = Vec3(-60, -48, -78), .blocks = {10, 8, 13}, .phases = 1},
                      [](const Vec3& x, double) { return testing::ellipsoid_distance(kAxes, x); });
  return field;
}

struct SlideErrors {
  double direction_deg = 0;
  double magnitude_p99 = 0;
  double step_n = 0;
  int lost = 0;
};

// W1: a tool slides 5 mm deep over an ellipsoid for 40 s.
SlideErrors slide_over_ellipsoid(const Field& field, double radius_mm, double stiffness,
                                 double depth_mm) {
  ProxyModel model(field, {.stiffness_n_per_m = stiffness, .radius_mm = radius_mm});
  SlideErrors worst;
  std::vector<double> magnitude;
  Vec3 last = Vec3::Zero();
  for (int n = 0; n < 40000; ++n) {
    const double t = kTick * n;
    const double theta = kPi * (0.5 + 0.35 * std::sin(0.37 * t));
    const double phi = 2 * kPi * 0.35 * t;
    const Vec3 on_sphere(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                         std::cos(theta));
    const Vec3 normal = on_sphere.cwiseQuotient(kAxes).normalized();
    const Vec3 x = on_sphere.cwiseProduct(kAxes) + (radius_mm - depth_mm) * normal;
    const Contact contact = model.evaluate(x, 0.0);
    if (!contact.touching) ++worst.lost;
    worst.direction_deg = std::max(worst.direction_deg, degrees_between(contact.force_n, normal));
    const double exact = stiffness * 1e-3 * depth_mm;
    magnitude.push_back(std::abs(contact.force_n.norm() / exact - 1));
    if (n > 0) worst.step_n = std::max(worst.step_n, (contact.force_n - last).norm());
    last = contact.force_n;
  }
  std::sort(magnitude.begin(), magnitude.end());
  worst.magnitude_p99 = magnitude[magnitude.size() * 99 / 100];
  return worst;
}

void expect_case_1(const SlideErrors& worst) {
  EXPECT_EQ(worst.lost, 0);
  EXPECT_LE(worst.direction_deg, 0.2);
  EXPECT_LE(worst.magnitude_p99, 0.001);
  EXPECT_LE(worst.step_n, 0.0061);
}

TEST(HardCase1, SlidingOverAnEllipsoidKeepsDirectionMagnitudeAndSteps) {
  for (const Field& field : {exact_ellipsoid(), packed_ellipsoid()}) {
    for (double radius_mm : {0.0, 3.0}) {
      SCOPED_TRACE(radius_mm);
      const SlideErrors worst = slide_over_ellipsoid(field, radius_mm, 400, 5);
      expect_case_1(worst);
      std::printf("  case 1, radius %.0f mm: %.4f deg, %.5f %%, step %.5f N\n", radius_mm,
                  worst.direction_deg, 100 * worst.magnitude_p99, worst.step_n);
    }
  }
}

// W2: R(t) of a sphere that swells by 5 mm at 1.25 Hz; every place of it moves, so no rigid motion
// could follow it.
constexpr double kBeat = 0.8;
double swell(double t) { return 5 * std::sin(2 * kPi * t / kBeat); }

Field exact_beating() {
  return std::make_shared<const FormField>(1.5, kBeat, [](const Vec3& x, double t) {
    const double rate = -5 * 2 * kPi / kBeat * std::cos(2 * kPi * t / kBeat);
    return made_sample(x.norm() - 30 - swell(t), x.normalized(), rate);
  });
}

Field packed_beating() {
  static const Field field = testing::packed(
      {.origin_mm = Vec3::Constant(-48), .blocks = {8, 8, 8}, .rr_interval_s = kBeat},
      [](const Vec3& x, double t) { return x.norm() - 30 - swell(t); });
  return field;
}

TEST(HardCase2, AStillToolLosesNoTickOfABeatingSurface) {
  for (const Field& field : {exact_beating(), packed_beating()}) {
    for (double radius_mm : {0.0, 3.0}) {
      ProxyModel model(field, {.stiffness_n_per_m = 400, .radius_mm = radius_mm});
      const Vec3 normal = Vec3(1, -2, 2) / 3;
      const Vec3 x = (28 + radius_mm) * normal;
      int contacts = 0;
      int lost = 0;
      double worst_n = 0;
      double worst_velocity = 0;
      for (int n = 0; n < 8000; ++n) {
        const double t = kTick * n;
        const double depth = 2 + swell(t);
        const Contact contact = model.evaluate(x, t);
        if (depth > 0) {
          ++contacts;
          // Thinner than the field's own error is no contact that could be lost.
          if (!contact.touching && depth > 0.005) ++lost;
          const double velocity = 5 * 2 * kPi / kBeat * std::cos(2 * kPi * t / kBeat);
          worst_velocity =
              std::max(worst_velocity, std::abs(contact.surface_velocity_mm_s - velocity));
        }
        worst_n = std::max(worst_n, (contact.force_n - 0.4 * std::max(0.0, depth) * normal).norm());
      }
      EXPECT_GE(contacts, 4719);
      EXPECT_EQ(lost, 0);
      EXPECT_LE(worst_n, 0.009);
      EXPECT_LE(worst_velocity, 0.4);  // 1 % of 39 mm/s
      std::printf("  case 2, radius %.0f mm: %d contacts, %d lost, %.5f N\n", radius_mm, contacts,
                  lost, worst_n);
    }
  }
}

TEST(HardCase2, AnEllipsoidThatTurnsAndSwellsUnevenlyLosesNoTick) {
  // Semi-axes swell out of step, so that the foot of a still tool wanders over the surface.
  const auto axes = [](double t) {
    const double w = 2 * kPi * t / kBeat;
    return Vec3(kAxes + 5 * Vec3(std::sin(w), std::sin(w + 1), std::sin(w + 2)));
  };
  const Field field = std::make_shared<const FormField>(1.5, kBeat, [&](const Vec3& x, double t) {
    const Vec3 a = axes(t);
    const Vec3 foot = testing::ellipsoid_nearest(a, x);
    constexpr double h = 1e-5;
    const double rate = (testing::ellipsoid_distance(axes(t + h), x) -
                         testing::ellipsoid_distance(axes(t - h), x)) /
                        (2 * h);
    return made_sample(testing::ellipsoid_distance(a, x),
                       foot.cwiseQuotient(a.cwiseAbs2()).normalized(), rate);
  });
  ProxyModel model(field, {.stiffness_n_per_m = 400});
  const Vec3 x = 0.88 * Vec3(25, 20, 33);
  double worst_n = 0;
  for (int n = 0; n < 4000; ++n) {
    const double t = kTick * n;
    const Vec3 a = axes(t);
    const double distance = testing::ellipsoid_distance(a, x);
    const Vec3 push = testing::ellipsoid_nearest(a, x) - x;
    const Contact contact = model.evaluate(x, t);
    EXPECT_EQ(contact.touching, distance < 0) << t;
    const Vec3 exact_n = distance < 0 ? Vec3(0.4 * push) : Vec3::Zero();
    worst_n = std::max(worst_n, (contact.force_n - exact_n).norm());
  }
  EXPECT_LE(worst_n, 0.009);
}

}  // namespace
}  // namespace beatlas::haptics::smooth_contact_tests
