#include "pipeline/shape/shared_places.h"

#include <array>
#include <functional>

#include <gtest/gtest.h>

namespace beatlas::shape::shared_places_tests {
namespace {

using Level = std::function<double(const Vec3& mm, int phase)>;

/// Samples 1 mm apart, from a corner of its own.
ShapeCycle shape(Structure structure, const Vec3& corner_mm, const Index3& size,
                 const Level& level) {
  ShapeCycle out;
  out.structure = structure;
  out.level.grid = {size, Affine(Eigen::Translation3d(corner_mm))};
  for (int phase = 0; phase < 2; ++phase) {
    std::vector<float>& samples = out.level.phases.emplace_back();
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) {
          samples.push_back(static_cast<float>(level(out.level.grid.mm(i, j, k), phase)));
        }
      }
    }
  }
  return out;
}

Level ball(const Vec3& centre, double radius) {
  return [=](const Vec3& mm, int phase) { return (mm - centre).norm() - radius - phase; };
}

constexpr float kNoSample = 1e9F;

/// The sample of a shape at a place of its lattice.
float at(const ShapeCycle& shape, const Vec3& mm, int phase) {
  const Vec3 index = mm - shape.level.grid.mm(0, 0, 0);
  Index3 n{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    n[axis] = static_cast<int>(index[static_cast<Eigen::Index>(axis)]);
    if (n[axis] < 0 || n[axis] >= shape.level.grid.size[axis]) return kNoSample;
  }
  return shape.level
      .phases[static_cast<std::size_t>(phase)][shape.level.grid.offset(n[0], n[1], n[2])];
}

void for_all_places(const std::function<void(const Vec3& mm, int phase)>& body) {
  for (int phase = 0; phase < 2; ++phase) {
    for (int k = -20; k <= 20; ++k) {
      for (int j = -20; j <= 20; ++j) {
        for (int i = -20; i <= 20; ++i) body(Vec3(i, j, k), phase);
      }
    }
  }
}

/// Blood of both ventricles and a wall that claim some places twice or three times, an atrium that
/// claims some of each, and a heart that ends within them.
struct Claims {
  std::array<Level, 5> level{ball({-5, 0, 0}, 8), ball({5, 1, 0}, 9), ball({0, 5, 2}, 7),
                             ball({0, 0, 9}, 7), ball({0, 0, 0}, 10)};
  std::vector<ShapeCycle> shapes{
      shape(Structure::LvBlood, {-18, -13, -12}, {27, 27, 25}, level[0]),
      shape(Structure::RvBlood, {-9, -12, -14}, {30, 28, 29}, level[1]),
      shape(Structure::LvMyocardium, {-11, -7, -9}, {22, 24, 23}, level[2]),
      shape(Structure::LaBlood, {-10, -11, -2}, {21, 22, 23}, level[3]),
      shape(Structure::Heart, {-19, -15, -15}, {40, 33, 35}, level[4])};
};

TEST(SharedPlaces, NoPlaceLiesInTwoStructuresAndTheHeartHoldsAll) {
  Claims made;
  settle_shared_places(made.shapes);
  std::size_t inside = 0;
  for_all_places([&](const Vec3& mm, int phase) {
    for (std::size_t a = 0; a < 4; ++a) {
      const float one = at(made.shapes[a], mm, phase);
      inside += one < 0 ? 1 : 0;
      if (one < 0) {
        EXPECT_LE(at(made.shapes[4], mm, phase), one);
      }
      for (std::size_t b = a + 1; b < 4; ++b) {
        EXPECT_GE(one + at(made.shapes[b], mm, phase), 0) << mm.transpose() << " " << a << b;
      }
    }
  });
  EXPECT_GT(inside, 5000U);
}

TEST(SharedPlaces, WhatTwoClaimIsPartedInItsMiddleAndNothingElseMoves) {
  Claims made;
  made.shapes.resize(2);
  settle_shared_places(made.shapes);
  for_all_places([&](const Vec3& mm, int phase) {
    const double left = made.level[0](mm, phase);
    const double right = made.level[1](mm, phase);
    if (at(made.shapes[0], mm, phase) == kNoSample || at(made.shapes[1], mm, phase) == kNoSample) {
      return;
    }
    for (std::size_t n = 0; n < 2; ++n) {
      const float found = at(made.shapes[n], mm, phase);
      const double own = n == 0 ? left : right;
      const double other = n == 0 ? right : left;
      // Closed form: inside is what the structure claims, nearer to it than to the other.
      EXPECT_NEAR(found, std::max(own, (own - other) / 2), 1e-5) << mm.transpose();
      if (own + other > 0) {
        EXPECT_NEAR(found, own, 1e-5);
      }
    }
  });
}

TEST(SharedPlaces, HeartAndVentriclesAreTheSameWhetherAtriaAreKnownOrNot) {
  Claims with;
  Claims without;
  without.shapes.erase(without.shapes.begin() + 3);
  settle_shared_places(with.shapes);
  settle_shared_places(without.shapes);
  for (std::size_t n = 0; n < 3; ++n) {
    EXPECT_EQ(with.shapes[n].level.phases, without.shapes[n].level.phases);
  }
  EXPECT_EQ(with.shapes[4].level.phases, without.shapes[3].level.phases);
}

TEST(SharedPlaces, AnAtriumGivesWayToVentricles) {
  Claims made;
  made.shapes.pop_back();  // no heart, within which it would have to lie
  settle_shared_places(made.shapes);
  for_all_places([&](const Vec3& mm, int phase) {
    if (!(made.level[3](mm, phase) < 0)) return;
    bool ventricle = false;
    for (std::size_t n = 0; n < 3; ++n) ventricle |= made.level[n](mm, phase) <= 0;
    EXPECT_EQ(at(made.shapes[3], mm, phase) < 0, !ventricle) << mm.transpose();
  });
}

TEST(SharedPlaces, TheHeartAndWhatStandsOutOfItMeetInTheMiddle) {
  Claims made;
  made.shapes = {made.shapes[0], made.shapes[4]};
  settle_shared_places(made.shapes);
  for_all_places([&](const Vec3& mm, int phase) {
    const float held = at(made.shapes[0], mm, phase);
    const float whole = at(made.shapes[1], mm, phase);
    if (held == kNoSample || whole == kNoSample) return;
    const double part = made.level[0](mm, phase);
    const double heart = made.level[4](mm, phase);
    EXPECT_NEAR(held, std::max(part, (part + heart) / 2), 1e-5);
    EXPECT_NEAR(whole, std::min(heart, (part + heart) / 2), 1e-5);
  });
}

}  // namespace
}  // namespace beatlas::shape::shared_places_tests
