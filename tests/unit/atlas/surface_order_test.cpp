#include "runtime/atlas/surface_order.h"

#include <random>

#include <gtest/gtest.h>

#include "runtime/atlas/surface_classes.h"

namespace beatlas::atlas {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

struct Sheet {
  Triangles triangles;
  std::vector<Vec3f> positions;
};

/// A torus, closed, with vertices moved along it at random.
Sheet torus(std::uint32_t around, std::uint32_t across) {
  Sheet out;
  std::mt19937 random(3);
  const auto jitter = [&random] {
    return 0.3 * (static_cast<double>(random()) / 4294967295.0 - 0.5);
  };
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < across; ++j) {
      const double a = 2 * EIGEN_PI * (i + jitter()) / around;
      const double b = 2 * EIGEN_PI * (j + jitter()) / across;
      const double r = 40 + 15 * std::cos(b);
      out.positions.push_back(
          Vec3(r * std::cos(a), r * std::sin(a), 15 * std::sin(b)).cast<float>());
      const auto at = [&](std::uint32_t di, std::uint32_t dj) {
        return (i + di) % around * across + (j + dj) % across;
      };
      out.triangles.push_back({at(0, 0), at(1, 0), at(1, 1)});
      out.triangles.push_back({at(0, 0), at(1, 1), at(0, 1)});
    }
  }
  return out;
}

void expect_order(const SurfaceOrder& order, std::size_t count) {
  ASSERT_EQ(order.vertices().size(), count);
  std::vector<bool> is_before(count, false);
  for (const std::uint32_t v : order.vertices()) {
    EXPECT_FALSE(is_before[v]);
    double sum = 0;
    const std::vector<double> weights = order.weights(v);
    ASSERT_EQ(weights.size(), order.known(v).size());
    for (std::size_t n = 0; n < weights.size(); ++n) {
      EXPECT_TRUE(is_before[order.known(v)[n]]);
      sum += weights[n];
    }
    if (!weights.empty()) {
      EXPECT_NEAR(sum, 1, 1e-12);
    }
    is_before[v] = true;
  }
}

TEST(SurfaceOrder, TakesEveryVertexOnceAndTellsItFromThoseBefore) {
  const Sheet sheet = torus(60, 24);
  const SurfaceOrder order(sheet.triangles, sheet.positions);
  expect_order(order, sheet.positions.size());
  std::size_t known = 0;
  for (std::uint32_t v = 0; v < sheet.positions.size(); ++v) known += order.known(v).size();
  // As many as a vertex has neighbours: six on average, not the three of an order along the mesh.
  EXPECT_GT(known, 5 * sheet.positions.size());
}

/// An affine motion is foretold up to the surface's own curvature; equal weights miss it by far
/// more.
TEST(SurfaceOrder, ForetellsAnAffineMotionOfAnUnevenMesh) {
  const Sheet sheet = torus(120, 48);
  const SurfaceOrder order(sheet.triangles, sheet.positions);
  const Vec3 gradient(0.1, -0.05, 0.2);
  double fitted = 0;
  double equal = 0;
  for (const std::uint32_t v : order.vertices()) {
    const auto known = order.known(v);
    if (known.size() < 3) continue;
    const std::vector<double> weights = order.weights(v);
    const double truth = gradient.dot(sheet.positions[v].cast<double>());
    double by_weight = 0;
    double mean = 0;
    for (std::size_t n = 0; n < known.size(); ++n) {
      const double value = gradient.dot(sheet.positions[known[n]].cast<double>());
      by_weight += weights[n] * value;
      mean += value / static_cast<double>(known.size());
    }
    fitted += std::abs(by_weight - truth);
    equal += std::abs(mean - truth);
  }
  EXPECT_LT(fitted, equal / 3);
}

TEST(SurfaceOrder, TakesAnyTrianglesInLinearTime) {
  // A hub that every triangle shares, vertices in one place, and a vertex on its own.
  constexpr std::uint32_t kRim = 100000;
  Sheet sheet;
  sheet.positions.assign(kRim + 2, Vec3f(1, 2, 3));
  for (std::uint32_t v = 1; v <= kRim; ++v) sheet.triangles.push_back({0, v, v % kRim + 1});
  const SurfaceOrder order(sheet.triangles, sheet.positions);
  expect_order(order, sheet.positions.size());
}

TEST(SurfaceOrder, HasOrthonormalFramesWithTheNormalFirst) {
  const Sheet sheet = torus(60, 24);
  const SurfaceOrder order(sheet.triangles, sheet.positions);
  for (std::uint32_t v = 0; v < sheet.positions.size(); ++v) {
    const Eigen::Matrix3d frame = order.frame(v);
    EXPECT_TRUE((frame * frame.transpose()).isIdentity(1e-12));
    const Vec3 x = sheet.positions[v].cast<double>();
    const Vec3 ring = 40 * Vec3(x.x(), x.y(), 0).normalized();
    EXPECT_GT(frame.row(0).dot((x - ring).normalized()), 0.95);
  }
}

TEST(MotionClasses, AreInRangeAndGrowWithWhatWasSeen) {
  for (const std::uint16_t scale : {1, 64, 65535}) {
    const std::vector<std::uint16_t> scales(std::size_t{2} * 1023, scale);
    MotionClasses calm(scales, 2);
    MotionClasses wild(scales, 2);
    const std::array<std::uint32_t, 1> first{0};
    for (const std::uint32_t v : {0U, 1U}) {
      calm.begin(v, std::span(first).first(v));
      wild.begin(v, std::span(first).first(v));
      for (std::size_t slot = 0; slot < calm.slots(); ++slot) {
        ASSERT_LT(calm.of(slot), kMotionClasses);
        ASSERT_LT(wild.of(slot), kMotionClasses);
        EXPECT_LE(calm.of(slot), wild.of(slot));
        calm.add(slot, 0);
        wild.add(slot, -(std::int64_t{1} << 31U));
      }
    }
    calm.begin(1, first);
    wild.begin(1, first);
    EXPECT_LT(calm.of(0), wild.of(0));
  }
}

}  // namespace
}  // namespace beatlas::atlas
