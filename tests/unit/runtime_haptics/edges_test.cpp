// Hard case 5: a 3 mm sphere over a 90-degree ridge and through a 90-degree groove, against closed
// form. The sphere's radius is 3 mm: of a smaller one the centre would pass under the ridge's edge
// at 2 mm, where the nearest way out changes from one face to the other and the exact force jumps.

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/haptics/proxy.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics {
namespace {

using testing::FormField;
using testing::made_sample;
using Field = std::shared_ptr<const ContactField>;

constexpr double kRadius = 3;
constexpr double kStiffness = 150;
constexpr double kDepth = 2;
constexpr double kStepMm = 0.1;  // 100 mm/s at 1 kHz
constexpr double kMostStep = 0.049;

// Axes of the edge's frame in the lattice: `u` and `v` across, `w` along it. Turned, so that no
// face lies along the samples.
const Eigen::Matrix3d& edge_axes() {
  static const Eigen::Matrix3d axes =
      (Eigen::AngleAxisd(0.5, Vec3::UnitX()) * Eigen::AngleAxisd(0.3, Vec3::UnitY()))
          .toRotationMatrix();
  return axes;
}

// u, v < 0 is the body of the ridge; u, v > 0 is the free space of the groove.
Vec2 across(const Vec3& x) { return {edge_axes().col(0).dot(x), edge_axes().col(1).dot(x)}; }
Vec3 along_axes(const Vec2& uv, double w = 0) {
  return uv[0] * edge_axes().col(0) + uv[1] * edge_axes().col(1) + w * edge_axes().col(2);
}

double ridge(const Vec2& p) {
  const double inside = std::min(std::max(p[0], p[1]), 0.0);
  return inside + p.cwiseMax(0).norm();
}
Vec2 ridge_gradient(const Vec2& p) {
  if (p[0] > 0 && p[1] > 0) return p.normalized();
  return p[0] > p[1] ? Vec2::UnitX() : Vec2::UnitY();
}
// Free space is u, v > 0: distance to the nearer of two planes.
double groove(const Vec2& p) {
  if (p[0] > 0 && p[1] > 0) return p.minCoeff();
  return -p.cwiseMin(0).norm();
}
Vec2 groove_gradient(const Vec2& p) {
  if (p[0] > 0 && p[1] > 0) return p[0] < p[1] ? Vec2::UnitX() : Vec2::UnitY();
  return -p.cwiseMin(0).normalized();
}

using Plane = double (*)(const Vec2&);

Field exact(Plane phi, Vec2 (*gradient)(const Vec2&)) {
  return std::make_shared<const FormField>(1.5, 1, [=](const Vec3& x, double) {
    return made_sample(phi(across(x)), along_axes(gradient(across(x))));
  });
}

Field in_an_atlas(Plane phi) {
  return testing::packed({.origin_mm = Vec3::Constant(-24), .blocks = {4, 4, 4}, .phases = 1},
                         [=](const Vec3& x, double) { return phi(across(x)); });
}

// Where the sphere's centre would be had it not gone in.
Vec2 free_of_ridge(const Vec2& p) {
  const double distance = ridge(p);
  return distance < kRadius ? Vec2(p + (kRadius - distance) * ridge_gradient(p)) : p;
}
Vec2 free_of_groove(const Vec2& p) { return p.cwiseMax(kRadius); }

struct Steps {
  double beyond_n = 0;  // of a step in force, beyond the exact one's
  double error_n = 0;
};

Steps follow(const Field& field, const std::vector<Vec2>& corners, Vec2 (*free)(const Vec2&),
             double along_mm_per_tick = 0) {
  ProxyModel model(field, {.stiffness_n_per_m = kStiffness, .radius_mm = kRadius});
  Steps worst;
  Vec3 last = Vec3::Zero();
  Vec3 last_exact = Vec3::Zero();
  bool first = true;
  double w = 0;
  for (std::size_t leg = 0; leg + 1 < corners.size(); ++leg) {
    const double length = (corners[leg + 1] - corners[leg]).norm();
    const int ticks = static_cast<int>(std::ceil(length / kStepMm));
    for (int n = 0; n < ticks; ++n) {
      const Vec2 p = corners[leg] + (corners[leg + 1] - corners[leg]) * n / ticks;
      w += along_mm_per_tick;
      const Vec3 force_n = model.evaluate(along_axes(p, w), 0).force_n;
      const Vec3 exact_n = kStiffness * 1e-3 * along_axes(free(p) - p);
      worst.error_n = std::max(worst.error_n, (force_n - exact_n).norm());
      if (!first) {
        const double step = (force_n - last).norm();
        worst.beyond_n = std::max(worst.beyond_n, step - (exact_n - last_exact).norm());
      }
      first = false;
      last = force_n;
      last_exact = exact_n;
    }
  }
  return worst;
}

// Along one face, 2 mm deep, over the edge and along the other; then back by a straight line.
std::vector<Vec2> over_the_ridge() {
  std::vector<Vec2> path{{-10, kRadius - kDepth}};
  for (int n = 0; n <= 20; ++n) {
    const double angle = 0.5 * M_PI * (1 - n / 20.0);
    path.emplace_back((kRadius - kDepth) * Vec2(std::cos(angle), std::sin(angle)));
  }
  path.emplace_back(kRadius - kDepth, -10);
  path.emplace_back(kRadius - kDepth, 10);
  path.emplace_back(10, kRadius - kDepth);
  path.emplace_back(-10, kRadius - kDepth);
  return path;
}

// Along one wall, 2 mm deep, into the corner, along the other; out and straight into the corner.
std::vector<Vec2> through_the_groove() {
  const double deep = kRadius - kDepth;
  const double diagonal = kRadius - kDepth / std::sqrt(2.0);
  return {{10, deep},      {diagonal, deep}, {diagonal, diagonal}, {deep, diagonal},
          {deep, 10},      {8, 8},           {diagonal, diagonal}, {8, 8},
          {kRadius, deep}, {10, deep}};
}

void report(const char* what, const Steps& steps) {
  EXPECT_LE(steps.beyond_n, kMostStep) << what;
  std::printf("  case 5, %s: step beyond motion %.5f N, error %.5f N\n", what, steps.beyond_n,
              steps.error_n);
}

TEST(HardCase5, ASphereOverARidgeFeelsNoStepBeyondItsMotion) {
  const Steps closed = follow(exact(ridge, ridge_gradient), over_the_ridge(), free_of_ridge);
  report("ridge, closed form", closed);
  EXPECT_LE(closed.error_n, 0.002);
  const Steps stored = follow(in_an_atlas(ridge), over_the_ridge(), free_of_ridge);
  report("ridge, atlas", stored);
  EXPECT_LE(stored.error_n, kMostStep);
}

TEST(HardCase5, ASphereThroughAGrooveFeelsNoStepBeyondItsMotion) {
  for (double along : {0.0, 0.02}) {
    const Steps closed =
        follow(exact(groove, groove_gradient), through_the_groove(), free_of_groove, along);
    report("groove, closed form", closed);
    EXPECT_LE(closed.error_n, 0.002);
    const Steps stored =
        follow(in_an_atlas(groove), through_the_groove(), free_of_groove, 0.5 * along);
    report("groove, atlas", stored);
  }
}

TEST(HardCase5, APointInTheCornerOfACubeIsHeldByThreeFaces) {
  // Free space is x, y, z > 0.
  const Field field = std::make_shared<const FormField>(1.5, 1, [](const Vec3& x, double) {
    if (x.minCoeff() <= 0) {
      const Vec3 in = -x.cwiseMin(0);
      return made_sample(-in.norm(), in.norm() > 0 ? Vec3(in.normalized()) : Vec3(Vec3::UnitX()));
    }
    Eigen::Index axis = 0;
    const double nearest = x.minCoeff(&axis);
    return made_sample(nearest, Vec3::Unit(axis));
  });
  ProxyModel model(field, {.radius_mm = 1});
  Vec3 x(4, 4, 4);
  for (int n = 0; n < 60; ++n) {
    x -= Vec3(0.08, 0.07, 0.06);
    const Contact contact = model.evaluate(x, 0);
    const Vec3 exact_n = 0.150 * (x.cwiseMax(1) - x);
    EXPECT_LT((contact.force_n - exact_n).norm(), 0.002) << n;
  }
}

}  // namespace
}  // namespace beatlas::haptics
